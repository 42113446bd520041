"""Whether the messages and the tests that name them agree: check_messages.py TESTS, or --self-test

messages.txt has each key once, in order, and a test for each; tests name no other key. What tests name is
each string "GROUP.NAME" whose group has messages, where it is not the name of a file.
"""
import pathlib
import re
import sys
import tempfile

FILE_KINDS = set("csv deep exr hdr html jpg json nvdb obj pbrt ply png pvol stl toml txt usda vdb".split())
NAMED = re.compile(r'"([a-z][a-z0-9_]*)\.([a-z][a-z0-9_]*)"')


def named_by(tests):
    sources = (p for p in tests.rglob("*") if p.suffix in (".cpp", ".h", ".py") and p.is_file())
    names = {name for p in sources for name in NAMED.findall(p.read_text(errors="replace"))}
    return {f"{group}.{name}" for group, name in names if name not in FILE_KINDS}


def faults_of(tests):
    lines = (tests / "messages.txt").read_text().splitlines()
    keys = [line.partition(": ")[0] for line in lines if line and not line.startswith("#")]
    groups = {key.partition(".")[0] for key in keys}
    named = {key for key in named_by(tests) if key.partition(".")[0] in groups}
    faults = [f"{key} does not come after {before}" for before, key in zip(keys, keys[1:]) if key <= before]
    faults += [f"no test names {key}" for key in keys if key not in named]
    faults += [f"there is no message {key}" for key in sorted(named.difference(keys))]
    return faults, len(keys)


def self_test():
    """Each planted fault alone must be found."""
    good = "# \nsmoke.hot: x\n\nsmoke.out: y: z\n"
    planted = (good.replace("smoke.out: y: z\n", ""), "smoke.out: x\nsmoke.hot: y\n",
               good.replace("\n\n", "\nsmoke.hot: x\n"), good.replace("\n\n", "\nsmoke.new: x\n"))
    with tempfile.TemporaryDirectory() as folder:
        tests = pathlib.Path(folder)
        (tests / "a_test.cpp").write_text('says(e, "smoke.out") says(e, "smoke.hot") says(e, "smoke.exr")')
        for text in (good, *planted):
            (tests / "messages.txt").write_text(text)
            faults, _ = faults_of(tests)
            assert len(faults) == (text != good), f"{text}{faults}"
    print(f"{len(planted)} planted faults found")


def main():
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    faults, count = faults_of(pathlib.Path(sys.argv[1]))
    print("\n".join(faults) or f"{count} messages")
    sys.exit(1 if faults or not count else 0)


if __name__ == "__main__":
    main()
