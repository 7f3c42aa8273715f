"""Blocks of paths on threads: from the kernel's arguments to rows of sums."""
