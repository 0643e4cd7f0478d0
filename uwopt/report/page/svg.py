"""Drawings for the page: only shapes and text pass, whatever names a drawing holds."""

from __future__ import annotations

import re
from xml.etree import ElementTree

SVG = "http://www.w3.org/2000/svg"
SHAPES = frozenset({
    "svg", "g", "path", "line", "polyline", "polygon", "rect", "circle", "ellipse", "text", "tspan", "title", "desc",
    "defs", "marker", "pattern", "clipPath", "linearGradient", "radialGradient", "stop", "mask", "use", "style",
})  # fmt: skip
INNER_LINK = re.compile(r"#[\w-]+\Z")


def clean_svg(text: str, prefix: str, alt: str) -> str:
    """A drawing with its harmless parts only, ids made unique; "" if it is no drawing."""
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError:
        return ""
    if local(root.tag) != "svg":
        return ""
    strip(root, prefix)
    root.set("role", "img")
    root.set("aria-label", alt)
    ElementTree.register_namespace("", SVG)
    return ElementTree.tostring(root, encoding="unicode")


def strip(node: ElementTree.Element, prefix: str) -> None:
    """Take away what is neither shape nor text, handlers, and links that lead out."""
    for child in list(node):
        if local(child.tag) not in SHAPES:
            node.remove(child)
        else:
            strip(child, prefix)
    for name, value in list(node.attrib.items()):
        plain = local(name).casefold()
        if plain.startswith("on") or (plain == "href" and not INNER_LINK.match(value)):
            del node.attrib[name]
        elif plain == "href":
            node.set(name, f"#{prefix}-{value[1:]}")
        elif plain == "id":
            node.set(name, f"{prefix}-{value}")
        elif "url(" in value:
            node.set(name, re.sub(r"url\(#([\w-]+)\)", rf"url(#{prefix}-\1)", value))
    if local(node.tag) == "style" and node.text and re.search(r"@import|url\s*\(|</", node.text):
        node.text = ""


def local(name: object) -> str:
    """A name without its namespace."""
    return str(name).rpartition("}")[2]
