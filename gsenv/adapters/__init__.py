"""Adapters to other RL libraries; each module imports its library, so import only those you use."""
