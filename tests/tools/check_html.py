"""Checks that pages are well-formed and load nothing: tags nest, drawings are XML, images are data."""

import html.parser
import re
import sys
import xml.etree.ElementTree

VOID = {"br", "col", "hr", "img", "input", "link", "meta", "wbr"}
DRAWN = {"path", "line", "rect", "circle"}  # closed by "/>" in drawings


class Checker(html.parser.HTMLParser):
    def __init__(self, file):
        super().__init__(convert_charrefs=True)
        self.file, self.open = file, []

    def refuse(self, message):
        line, column = self.getpos()
        sys.exit(f"{self.file}:{line}:{column}: {message}")

    def handle_starttag(self, tag, attributes):
        names = [name for name, _ in attributes]
        if len(names) != len(set(names)):
            self.refuse(f"<{tag}> has an attribute twice")
        for name, value in attributes:
            if name in ("src", "href") and not (value or "").startswith("data:image/png;base64,"):
                self.refuse(f"<{tag}> loads {value}")
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        if tag not in DRAWN:
            self.refuse(f"<{tag}/> is closed at once")

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            self.refuse(f"</{tag}> closes nothing")


for file in sys.argv[1:]:
    with open(file, encoding="utf-8") as stream:
        text = stream.read()
    checker = Checker(file)
    checker.feed(text)
    checker.close()
    if checker.open:
        sys.exit(f"{file}: <{checker.open[-1]}> is never closed")
    if not text.startswith("<!DOCTYPE html>") or "</html>" not in text:
        sys.exit(f"{file}: is no whole document")
    for drawing in re.findall(r"<svg.*?</svg>", text, re.DOTALL):
        xml.etree.ElementTree.fromstring(drawing)
    style = re.search(r"<style>(.*?)</style>", text, re.DOTALL).group(1)
    if "url(" in style or "@import" in style or style.count("{") != style.count("}"):
        sys.exit(f"{file}: the style loads something or does not nest")
