"""The layered shell: energy, gradient and Hessian of a film's vertices, in Warp kernels."""
