"""Entry points: kernels over arrays of rays, which choose the route of each ray and write its answer.

Coherent rays go in packets of 64, others in streams or one by one. Single rays are those in doubt, those beside others
that see something else, and those of integrators. The only ray of a query goes as a packet whose other lanes are idle.
"""
