"""A Monte Carlo of lamp light in water with all orders of scattering: the reference of the multiple-scattering section.

`walk` holds the steps that all share, `lamps` light from a lamp to a place, `camera` what a pixel sees, `photons`
a second estimator that shares nothing but the steps, `slabs` known numbers, `cases` the table; `daylight` is the same
under a sky, `sunlit` what the model makes of that. Needs numba to run fast.
"""
