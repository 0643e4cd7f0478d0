"""What a system would see. The light's way, one file a stage:

spectrum    the grid, integrals, black bodies
light       lumens to watts per nanometre, electrical power, pulses; flash: how a flash's light falls off
beam        where a lamp's light goes; widened: by what is scattered on the way, as its halo
water       what the way to the floor and back takes (path_table: contracted over both legs)
scattering  phase functions as tables: how much light is turned where; sent_back: where it has turned; phase_formulas
multiple    light scattered more than once, as attenuations less than c; detail: what shows in it all the same
veil        light of the lamps that water scatters back (geometry, ray, mean), or forward by much (wide, by spots)
sunlight    daylight at depth, on the floor and along the path
seafloor    what comes back
port        window between water and air: rays, focus, losses
lens        image irradiance, depth of field; f_stops: its marks; extension: how near it focuses, on a ring too
defocus     blur of what is out of focus, behind flat ports and domes
lateral     the spread of colours behind a flat port
sharpness   MTF of all stages; aberration: what the lens itself takes
information what an image tells of a texture, over spatial frequencies
sensor      electrons, digital numbers, signal to noise
operation   motion: blur, overlap, frame rate
stereo      a pair of cameras: what both see, how well they tell a distance
enclosure   the room that a camera and its lens need; hull: walls that hold the water out; housing_heat inside them
imaging     the stages put in a row at a point; image_mean over the image, footprint over the floor
effects     which parts of the physics are kept; fineness: how finely integrals are taken
bisection   where a condition ceases to hold; falling_root: where a function meets a level

Pure functions: arrays in, arrays out, no files, no parts, no solvers.
"""
