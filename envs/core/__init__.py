"""What all tasks share: base classes, vector environments, arguments, random streams, policies."""
