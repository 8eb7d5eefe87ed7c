"""Tapes: formulas that `numerics.tracing` records for one body, played for many.

`simd_interpreter` plays them for many bodies side by side, in numbers of four floats (`simd_registers`,
`simd_sine_cosine`). What these leave undecided `interpreter` plays body by body, in numbers of 253 bits and more with
bounds (`bigfloat_kernel`, `bigfloat_functions`, `bigfloat_rounding`); `bigfloat_to_quad` cuts these to four floats.
`program` turns a recording into arrays, `schedule` orders its operations, and `recording_cache` keeps recordings of the
process.
"""
