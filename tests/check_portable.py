"""Whether the installed headers are what other compilers can read:
check_portable.py FOLDER_OF_BUILD'S_HEADERS FOLDER_OF_THE_PROJECT COMPILER INSTALLED_HEADER...

They compile in the standards that they are written for, with -pedantic-errors, by the compiler that is
named and by g++ and clang++ where they are installed; and none of them holds an extension of GCC and
Clang, not even one that these two accept silently. The attributes of GCC that they bear must be of
those that say how fast something is to be and not what it does: other compilers skip them.
"""
import collections
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

# Languages of headers that are not of C++20: "pvol/capi.h": ["c99", "c++17"].
LANGUAGES = {
    "pvol/pvol.h": ["c99", "c++17"],
    "pvol/pvol.hpp": ["c++17"],
    # Through lanes.h, which takes one of them.
    "pvol/math/float4_neon.h": [],
    "pvol/math/float4_plain.h": [],
    "pvol/math/float4_sse2.h": [],
}
# Headers that are to be light to include: at most so many times these standard headers, which they need.
LIGHT = {"pvol/pvol.hpp": (1.4, ["array", "optional"])}
# Headers take other ways where these are given.
VARIANTS = [[], ["-DPVOL_PLAIN_LANES"]]
FLAGS = ["-pedantic-errors", "-Wall", "-Wextra", "-Werror", "-fsyntax-only"]

EXTENSIONS = re.compile(r"\b(__int128\w*|__uint128_t|vector_size|ext_vector_type|__builtin_\w+|__attribute__"
                        r"|__extension__|__typeof__|typeof|__asm__|asm|__restrict\w*|__declspec|__forceinline)\b")
ATTRIBUTES = re.compile(r"\[\[([^]]*)\]\]")
WITHOUT_MEANING = {"gnu::always_inline", "gnu::noinline", "gnu::flatten", "gnu::cold", "gnu::hot"}
COMMENTS = re.compile(r"//[^\n]*|/\*.*?\*/|\"(?:\\.|[^\"\\\n])*\"", re.DOTALL)


def name_of(path):
    """pvol/... of a path in the build's list."""
    return path[path.index("include/pvol/") + len("include/"):]


def find_extensions(name, text, skipped):
    """Faults in the text of a header; counts the attributes that others skip."""
    text = COMMENTS.sub("", text)
    for word in sorted(set(EXTENSIONS.findall(text))):
        yield f"{name} uses {word}, which not all compilers know"
    for group in ATTRIBUTES.findall(text):
        for attribute in re.findall(r"\w+::\w+", group):
            skipped[attribute] += 1
            if attribute not in WITHOUT_MEANING:
                yield f"{name} means something by [[{attribute}]], which not all compilers know"


def compilers_of(named):
    """By path, so that none is asked twice."""
    found = [named] + [path for path in map(shutil.which, ("g++", "clang++")) if path]
    return list({pathlib.Path(path).resolve(): path for path in found}.values())


def compile_together(compiler, standard, names, folders, variant):
    """What a compiler complains of in a source of a language that includes all of these."""
    source = "".join(f'#include "{name}"\n' for name in names)
    language = "c++" if "++" in standard else "c"
    command = [compiler, f"-std={standard}", *FLAGS, *variant, *(f"-I{f}" for f in folders), "-x", language, "-"]
    run = subprocess.run(command, input=source, capture_output=True, text=True)
    if run.returncode == 0:
        return []
    first = [line for line in run.stderr.splitlines() if "error" in line][:3]
    return [f"{' '.join([pathlib.Path(compiler).name, standard, *variant])}: {line}" for line in first]


def weigh(compiler, name, needed, folders):
    """The size of a header after preprocessing, as a multiple of that of the standard headers it needs."""
    language = next(s for s in LANGUAGES[name] if "++" in s)
    system = [f"#include <{header}>" for header in needed]

    def size(source):
        command = [compiler, f"-std={language}", *(f"-I{f}" for f in folders), "-E", "-P", "-x", "c++", "-"]
        return len(subprocess.run(command, input=source, capture_output=True, text=True, check=True).stdout)

    return size(f'#include "{name}"\n') / size("\n".join(system) + "\n")


def find_faults(build, project, compiler, installed):
    folders = [project / "libpvol/include", build]
    names = sorted(map(name_of, installed))
    faults, skipped = [], collections.Counter()
    for name in names:
        path = next((f / name for f in folders if (f / name).is_file()), None)
        if path is None:
            faults.append(f"{name} is installed, and there is no such header")
        else:
            faults += find_extensions(name, path.read_text(), skipped)
    languages = collections.defaultdict(list)
    for name in names:
        for standard in LANGUAGES.get(name, ["c++20"]):
            languages[standard].append(name)
    for name in set(LIGHT) & set(names):
        most, needed = LIGHT[name]
        weight = weigh(compiler, name, needed, folders)
        if weight > most:
            faults.append(f"{name} is {weight:.2f} times <{'> and <'.join(needed)}>, more than {most}")
    compilers = compilers_of(compiler)
    for each in compilers:
        for standard, theirs in languages.items():
            for variant in VARIANTS:
                faults += compile_together(each, standard, theirs, folders, variant)
    return faults, f"{len(names)} headers in {', '.join(sorted(languages))} by " \
                   f"{' and '.join(pathlib.Path(c).name for c in compilers)}; skipped by others: " \
                   f"{', '.join(f'{n} {a}' for a, n in sorted(skipped.items())) or 'nothing'}"


PLANTED = [  # texts of a header, and whether there is a fault
    ("inline int f() { return 1; }  // not __int128\n", False),
    ("struct S { [[nodiscard, gnu::always_inline]] int f() { return 1; } };\n", False),
    ("__extension__ using Wide = unsigned __int128;\n", True),
    ("inline int f(unsigned x) { return __builtin_popcount(x); }\n", True),
    ("struct [[gnu::packed]] S { char a; int b; };\n", True),
    ("using Four = float __attribute__((vector_size(16)));\n", True),
    ("struct S { union { int a; struct { int b, c; }; }; };\n", True),   # by -pedantic-errors
    ("inline int f(int unused) { return 1; }\n", True),                   # by a warning
    ("#ifdef PVOL_PLAIN_LANES\n#error none\n#endif\n", True),
]


def self_test(compiler):
    """Each fault alone must be found, by one compiler at least."""
    for text, is_fault in PLANTED:
        with tempfile.TemporaryDirectory() as folder:
            project = pathlib.Path(folder)
            file = project / "libpvol/include/pvol/embed.h"
            file.parent.mkdir(parents=True)
            file.write_text("#pragma once\n" + text)
            faults, _ = find_faults(project, project, compiler, [str(file)])
            assert bool(faults) == is_fault, f"{text}: {faults}"
    print(f"{sum(is_fault for _, is_fault in PLANTED)} planted faults found")


def main():
    if sys.argv[1] == "--self-test":
        return self_test(sys.argv[2])
    build, project, compiler, *installed = sys.argv[1:]
    faults, summary = find_faults(pathlib.Path(build), pathlib.Path(project), compiler, installed)
    print("\n".join([*faults, summary]))
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
