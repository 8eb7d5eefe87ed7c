"""Files that are not text, or not YAML, and faults of the file as a whole."""

from .case import broken, sphere

# No text, no YAML ---------------------------------------------------------------------------------
CASES = [
    broken("empty", "", 0, "is empty"),
    broken("only spaces", "  \n\n", 0, "is empty"),
    broken("only comments", "# nothing\n# here\n", 0, "is empty"),
    broken("null", "~\n", 0, "is empty"),
    broken("only a document marker", "---\n", 0, "is empty"),
    broken("binary", b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR\x00\x00", 1, "binary", "0x89"),
    broken("zero byte", b"bodies:\n  - \x00\n", 2, "binary", "zero byte"),
    broken("latin 1", "bodies:\n  - name: b\xe4r\n".encode("latin-1"), 2, "UTF-8", "0xe4"),
    broken("utf-16", "bodies: []\n".encode("utf-16"), 0, "UTF-16", "UTF-8"),
    broken("half a character", b"bodies: []  # \xc3", 1, "UTF-8", "0xc3"),
    broken("control character", b"bodies:\n - \x07\n", 2, "control characters", "U+0007"),
    broken("tab as indent", "bodies:\n\t- name: a\n", 2, "not YAML", r"cannot start any token at '\t'"),
    broken("open bracket", "bodies: [\n", 2, "not YAML", "flow"),
    broken("open quote", 'bodies: "abc\n', 2, "not YAML", "quoted scalar"),
    broken("wrong indent", "bodies:\n  - name: a\n shape: b\n", 3, "not YAML"),
    broken("two colons", "bodies: a: b\n", 1, "not YAML", "mapping values are not allowed"),
    broken("two documents", "bodies: []\n---\nbodies: []\n", 2, "one document"),
    broken("unknown alias", "bodies: *here\n", 1, "alias *here has no anchor"),
    broken("alias in itself", "bodies: &a\n  - *a\n", 2, "alias *a lies inside"),
    broken(
        "tag that makes an object", 'bodies: !!python/object/apply:os.system ["exit 1"]\n', 1, "tags", "python/object"
    ),
    broken("tag of a number", "bodies:\n - shape: {Sphere: {radius: !!float 1}}\n", 2, "tags", "not allowed"),
    broken("tag directive", "%TAG ! tag:example.org,2000:\n---\nbodies: []\n", 1, "directive", "not allowed"),
    broken("list as key", "? [a, b]\n: 1\n", 1, "a key must be a word"),
    broken("key given twice", "bodies: []\nlights: []\nbodies: []\n", 3, "'bodies' is given twice", "line 1"),
    broken("field given twice", sphere("{radius: 1,\n   radius: 2}"), 3, "'radius' is given twice", "line 2"),
    broken("deep brackets", "bodies: " + "[" * 300 + "]" * 300, 1, "nested deeper than 250"),
    broken("deep mappings", "bodies: " + "{a: " * 300 + "1" + "}" * 300, 1, "nested deeper than 250"),
    broken(
        "billion laughs",
        "a0: &a0 [1,1,1,1,1,1,1,1,1,1]\n"
        + "".join(f"a{i}: &a{i} [{','.join([f'*a{i - 1}'] * 10)}]\n" for i in range(1, 12)),
        6,
        "more than 1,000,000 values, aliases expanded",
    ),
    # The file as a whole ------------------------------------------------------------------------------
    broken("a word", "hello\n", 1, "must be a mapping with", "bodies", "got 'hello'"),
    broken("a list", "- Sphere\n", 1, "must be a mapping with", "got ['Sphere']"),
    broken("a number", "3\n", 1, "must be a mapping with", "got 3"),
    broken("no bodies", "lights: []\n", 1, "bodies must be given"),
    broken("unknown section", "bodies: []\ncamra: {}\n", 2, "unknown key 'camra'", "did you mean 'camera'?"),
    broken("merge key", "<<: {a: 1}\nbodies: []\n", 1, "unknown key '<<'"),
    broken("newer format", "conicoid: 2\nbodies: []\n", 1, "conicoid: must be 1", "got 2"),
    broken("format as text", "conicoid: one\nbodies: []\n", 1, "conicoid: must be an integer", "got 'one'"),
    broken("bodies as a mapping", "bodies:\n  a: {shape: {Sphere: {}}}\n", 2, "bodies: must be a list"),
    broken("bodies as a word", "bodies: many\n", 1, "bodies: must be a list", "got 'many'"),
]
