"""Check what an installation of fvkit with its hard dependencies alone brings in: run by the Python of that environment.

A package that appears on its own, or one that suddenly has native code, is looked at before it is let in: add it to KNOWN then.
"""

from importlib.metadata import distributions

#: Package -> whether it holds native code.
KNOWN = {"attrs": False, "contourpy": True, "cycler": False, "fonttools": True, "kiwisolver": True, "matplotlib": True,
         "numpy": True, "packaging": False, "pillow": True, "pyparsing": False, "python-dateutil": False, "scipy": True,
         "six": False, "tzdata": False}
#: Part of every environment.
TOOLS = {"pip", "setuptools", "wheel"}
NATIVE = (".so", ".pyd", ".dylib")


def main():
    """Compare the installed packages with the known ones."""
    found = {item.metadata["Name"].lower().replace("_", "-"): any(str(file).endswith(NATIVE) for file in item.files or ())
             for item in distributions()}
    for tool in TOOLS:
        found.pop(tool, None)
    if found.pop("fvkit", True):
        raise SystemExit("fvkit is not installed here, or holds native code")
    new = sorted(set(found) - set(KNOWN))
    native = sorted(name for name in set(found) & set(KNOWN) if found[name] and not KNOWN[name])
    if new or native:
        raise SystemExit(f"new dependencies: {', '.join(new) or 'none'}; native code is new in: {', '.join(native) or 'none'}. "
                         f"Look at them, then add them to KNOWN in {__file__}")
    compiled = sorted(name for name in found if found[name])
    print(f"{len(found)} packages beside fvkit, all known; native code in {', '.join(compiled)}")


if __name__ == "__main__":
    main()
