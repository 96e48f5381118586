"""Software rendering: a world becomes a draw list, a draw list becomes a uint8 image or a video."""
