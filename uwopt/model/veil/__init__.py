"""Light that lamps scatter back into the camera, along a ray and as the mean over an image."""
