"""What techniques cost: in kernels, beside them, and at the least; and how much of the work is serial."""
