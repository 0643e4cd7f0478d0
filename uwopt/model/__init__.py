"""What a system would see. The light's way, one file a stage:

spectrum   the grid, integrals, black bodies
light      lumens to watts per nanometre, electrical power, pulses
beam       where a lamp's light goes
water      what the way to the floor and back takes (path_table: contracted over both legs)
seafloor   what comes back
port       window between water and air: rays, focus, losses
lens       image irradiance, depth of field
sensor     electrons, digital numbers, signal to noise
operation  motion: blur, overlap, frame rate
imaging    the stages put in a row

Pure functions: arrays in, arrays out, no files, no parts, no solvers.
"""
