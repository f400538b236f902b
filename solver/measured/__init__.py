"""Measured things: files of surfaces and curves, their comparison with a run, and fits. No run needs them.

The way of a file:

content                        its bytes or text; what is no measurement
units, headings                lengths, forces and times; names and units of columns
lines, layout                  lines without comments and commas of thousands; how they are cut into cells
tables                         the block of numbers, its columns, the lines above
columns                        which column is what, by name or as given; else a refusal that shows the table
instruments                    surfaces and force curves in the files of instruments
periodic, profile              a surface: x and z, made periodic
noise, comparison              noise and slips of a curve; a curve beside that of a run
measurement                    one stroke of friction with its noise; any curve in segments
roles, curves                  a curve: which column is what; its kind, its segments, its units
trial, stroke_fit, loop_fit, fit
                               parameters of a scene from a curve
"""
