"""Grid kernels and Fourier transforms for any array library; their memory and threads."""
