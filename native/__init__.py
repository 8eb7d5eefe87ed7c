"""Machine code for wheels: kernels compiled beforehand for each processor, and the door to them."""
