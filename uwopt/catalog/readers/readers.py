"""The readers of all kinds of parts."""

from uwopt.catalog.readers import read_camera, read_complete, read_housing, read_lens, read_light, read_port
from uwopt.catalog.readers.reading import Reader

READERS: dict[str, Reader] = {
    "camera": read_camera.READER,
    "lens": read_lens.READER,
    "port": read_port.READER,
    "light": read_light.READER,
    "housing": read_housing.READER,
    "complete": read_complete.READER,
}
