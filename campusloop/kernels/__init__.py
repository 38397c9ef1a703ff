"""The numerical kernels as a whole: which command needs which, whether their caches hold, compiling them."""
