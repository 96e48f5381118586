"""What all benchmarks share: stamps, timing, tables, plots, files and progress."""
