"""The search itself: compiled kernels on flat arrays. They know nodes and seconds, no rides and no clocks."""
