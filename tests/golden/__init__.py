"""What the program computes today, bit by bit, to compare with after a change that must not change it."""
