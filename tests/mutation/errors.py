"""Errors of one line that tests/mutate plants: what they are, and which are chosen."""
import fnmatch
import pathlib
import random
import re
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent

# What errors are planted in.
SOURCES = ["libpvol/src/*", "libpvol/include/*", "formats/src/*", "formats/include/*", "tools/cli/*"]

# (what to look for in code without comments and strings, what to put there)
OPERATORS = [(re.compile(pattern), new) for pattern, new in [
    (r"(?<= )<(?= )", "<="), (r"(?<= )<=(?= )", "<"),
    (r"(?<= )>(?= )", ">="), (r"(?<= )>=(?= )", ">"),
    (r"(?<= )==(?= )", "!="), (r"(?<= )!=(?= )", "=="),
    (r"(?<= )\+(?= )", "-"), (r"(?<= )-(?= )", "+"),
    (r"(?<= )\*(?= )", "/"), (r"(?<= )/(?= )", "*"),
    (r"(?<= )\+=(?= )", "-="), (r"(?<= )-=(?= )", "+="), (r"(?<= )\*=(?= )", "/="),
    (r"\bmin\b(?=[(<])", "max"), (r"\bmax\b(?=[(<])", "min"),
    (r"\+\+", "--"), (r"--(?!\))", "++"),
    (r"\btrue\b", "false"), (r"\bfalse\b", "true"),
    (r"(?<= )&&(?= )", "||"), (r"(?<= )\|\|(?= )", "&&"),
    (r"(?<![\w.])0(?![\w.'])", "1"), (r"(?<![\w.])1(?![\w.'])", "0"),
    (r"(?<= )<<(?= )", ">>"), (r"(?<= )>>(?= )", "<<"),
    (r"(?<=return )(?!\{\}|true\b|false\b)[^;{}]+(?=;$)", "{}"),
    (r"^ +[\w:.>()\[\]*-]+ [-+*/|&^]?= [^;{]+;$", ";"),         # an assignment
    (r"^ +(?!return\b|throw\b)[\w:.>-]+\([^;{]*\);$", ";"),     # a call
]]
# Lines that say what things are, not what happens; and messages of errors.
NO_CODE = re.compile(r"^ *(#|(static_assert|assert|template|using|namespace|friend|enum|case|"
                     r"default|throw|refuse)\b)")
COMMENT_OR_TEXT = re.compile(
    r"""//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|(?<!\w)'(?:\\.|[^'\\\n])+'""", re.S)


def code_of(text):
    """The text with comments and strings blanked, of the same length."""
    return COMMENT_OR_TEXT.sub(lambda m: re.sub(r"[^\n]", " ", m.group()), text)


def mutants_of(text):
    """(line number, line as it is, line with an error) for every error there could be."""
    lines = text.split("\n")
    found, before = {}, ";"
    for number, code in enumerate(code_of(text).split("\n")):
        bare = code.rstrip()
        whole = before[-1:] in ";{}:"  # of a statement: it begins here
        if bare.strip():
            before = bare
        if NO_CODE.match(code):
            continue
        for pattern, new in OPERATORS:
            if new == ";" and (not whole or bare.count("(") != bare.count(")")):
                continue
            for m in pattern.finditer(bare):
                old = lines[number]
                if new == ";":
                    planted = re.match(" *", old).group() + ";" + old[len(bare):]
                else:
                    planted = old[:m.start()] + new + old[m.end():]
                found[number + 1, old, planted] = None
    return list(found)



def code_files(globs):
    """The files of SOURCES that fit, from the project's root."""
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, check=True, capture_output=True, text=True).stdout
    for name in listed.splitlines():
        if re.search(r"\.(h|cpp)$", name) and any(fnmatch.fnmatch(name, s) for s in SOURCES):
            if not globs or any(fnmatch.fnmatch(name, g) for g in globs):
                yield name


def choose(names, count, seed):
    """(file, mutant) of `count` errors, by file."""
    every = [(name, m) for name in names for m in mutants_of((ROOT / name).read_text())]
    return sorted(random.Random(seed).sample(every, min(count, len(every))))


SAMPLE = """\
// never < here
int f(int a) {
  text = "nor < here"; /* nor
  a < b */ return a < 1;
}
"""


def check_sample():
    """What is wrong with the errors of SAMPLE, as a list of lines."""
    planted = {(number, new.strip()) for number, _, new in mutants_of(SAMPLE)}
    expected = {(4, f"a < b */ return {value};") for value in ("a <= 1", "a < 0", "{}")}
    expected.add((3, "; /* nor"))
    return [f"the sample has other errors: {sorted(planted ^ expected)}"] if planted != expected else []
