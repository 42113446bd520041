"""Whether the code on a page is code that runs: check_recipes.py PAGE SOURCE

Each fenced block of C on the page is one of the recipes of the source, which stand between the lines
"/* recipe: NAME */" and "/* end */", and each recipe is on the page.
"""
import pathlib
import re
import sys


def main():
    page, source = (pathlib.Path(p).read_text() for p in sys.argv[1:3])
    quoted = re.findall(r"```c\n(.*?)```", page, re.DOTALL)
    recipes = dict(re.findall(r"/\* recipe: ([a-z ]+) \*/\n(.*?)/\* end \*/", source, re.DOTALL))
    faults = [f"the page has no {name}, or an older one" for name, code in recipes.items() if code not in quoted]
    faults += [f"the source has no such code:\n{code}" for code in quoted if code not in recipes.values()]
    print("\n".join(faults) or f"{len(recipes)} recipes")
    sys.exit(1 if faults or not recipes else 0)


main()
