"""URDFs of every sort: sound chains and trees, with a few things in them that are not as they should be."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from xml.sax.saxutils import escape, quoteattr

import numpy as np

from fuzz.hostile import FACTORS, INJECTED, Rng, chance, mutate_bytes, name, number, pick

Element = list  # [tag, attributes, children]: unlike a parser's own, it can hold what no parser takes

KINDS = ("revolute", "continuous", "prismatic")
ODD_KINDS = ("fixed", "floating", "planar", "spherical", "Revolute", "", "revolute ")
COLOURS = ("1 0 0 1", "red", "2 -1 0 1", "nan 0 0 1", "", "1 0 0", "#ff0000", "1 0 0 1 1")
MESHES = ("package://nowhere/x.stl", "x.dae", "/dev/zero", "http://localhost:1/x.stl", "", "arm.urdf", "..")


def triple(rng: Rng, reach: float) -> str:
    """Three numbers."""
    return " ".join(repr(round(float(x), 6)) for x in rng.uniform(-reach, reach, 3))


def sound(rng: Rng, joints: int) -> Element:
    """An arm that can be loaded: a chain, with a branch or a fixed joint now and then."""
    root: Element = ["robot", {"name": "r"}, [link(rng, "base", inertial=chance(rng, 0.3))]]
    ends = ["base"]
    for k in range(joints):
        parent = ends[-1] if chance(rng, 0.85) else str(pick(rng, ends))
        kind = str(rng.choice(KINDS, p=[0.7, 0.2, 0.1]))
        root[2] += [link(rng, f"link{k}"), joint(rng, f"joint{k}", parent, f"link{k}", kind)]
        ends.append(f"link{k}")
        if chance(rng, 0.2):
            root[2] += [
                link(rng, f"flange{k}", inertial=chance(rng, 0.5)),
                joint(rng, f"weld{k}", f"link{k}", f"flange{k}", "fixed"),
            ]
            ends.append(f"flange{k}")
    if chance(rng, 0.2):
        rng.shuffle(root[2])
    return root


def link(rng: Rng, label: str, inertial: bool = True) -> Element:
    """A link whose inertia is that of a cloud of points, with something to see now and then."""
    parts: list[Element] = []
    if inertial:
        cloud = rng.normal(size=(4, 3)) * 10.0 ** rng.uniform(-2.0, -0.5)
        tensor = np.eye(3) * (cloud**2).sum() - cloud.T @ cloud + 1e-4 * np.eye(3)
        entries = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
        parts.append(
            [
                "inertial",
                {},
                [
                    ["origin", {"xyz": triple(rng, 0.2), "rpy": triple(rng, 3.0)}, []],
                    ["mass", {"value": repr(float(10.0 ** rng.uniform(-1.0, 1.0)))}, []],
                    ["inertia", {key: repr(float(tensor[at])) for key, at in entries.items()}, []],
                ],
            ]
        )
    if chance(rng, 0.4):
        parts.append([str(pick(rng, ["visual", "visual", "collision"])), {}, _shape(rng)])
    return ["link", {"name": label}, parts]


def _shape(rng: Rng) -> list[Element]:
    size = repr(float(rng.uniform(0.01, 0.2)))
    body: Element = pick(
        rng,
        [
            ["box", {"size": " ".join([size] * 3)}, []],
            ["cylinder", {"radius": size, "length": size}, []],
            ["sphere", {"radius": size}, []],
            ["mesh", {"filename": str(pick(rng, MESHES))}, []],
            ["capsule", {"radius": size, "length": size}, []],
        ],
    )
    colour: Element = ["color", {"rgba": str(pick(rng, COLOURS))}, []]
    return [
        ["origin", {"xyz": triple(rng, 0.2), "rpy": triple(rng, 3.0)}, []],
        ["geometry", {}, [body]],
        ["material", {"name": str(pick(rng, ["m", "m", ""]))}, [colour] if chance(rng, 0.7) else []],
    ]


def joint(rng: Rng, label: str, parent: str, child: str, kind: str) -> Element:
    """A joint with an origin, an axis and limits."""
    axis = triple(rng, 1.0) if chance(rng, 0.5) else str(pick(rng, ["1 0 0", "0 1 0", "0 0 1", "0 0 -1"]))
    parts: list[Element] = [
        ["parent", {"link": parent}, []],
        ["child", {"link": child}, []],
        ["origin", {"xyz": triple(rng, 0.4), "rpy": triple(rng, 3.0)}, []],
    ]
    if kind != "fixed":
        limit = {"lower": "-2", "upper": "2", "effort": "50", "velocity": "3"}
        parts += [["axis", {"xyz": axis}, []], ["limit", limit, []]]
        if chance(rng, 0.3):
            parts.append(["dynamics", {"friction": "0.5", "damping": "0.1"}, []])
        if chance(rng, 0.02):
            parts.append(["mimic", {"joint": f"joint{int(rng.integers(3))}", "multiplier": "2", "offset": "0.1"}, []])
    return ["joint", {"name": label, "type": kind}, parts]


def elements(root: Element) -> list[Element]:
    """All elements below and with the root."""
    found, waiting = [], [root]
    while waiting:
        found.append(waiting.pop())
        waiting += found[-1][2]
    return found


def scaled(word: str, factor: float) -> str:
    """A number times a factor; what is none as it is."""
    try:
        return repr(float(word) * factor)
    except ValueError:
        return word


def disturb(rng: Rng, root: Element) -> None:
    """One thing that is not as it should be."""
    everything = elements(root)
    at = pick(rng, everything)
    how = int(rng.choice([*range(16), 2, 2, 2]))
    joints = [e for e in everything if e[0] == "joint"]
    if how <= 1 and at[1]:
        at[1][pick(rng, sorted(at[1]))] = number(rng)
    elif how == 2:
        figures = [
            e
            for e in everything
            if e[0] in ("mass", "inertia", "origin", "axis", "limit", "dynamics", "mimic") and e[1]
        ]
        for e in figures[int(rng.integers(len(figures))) :][:1] if figures else []:
            key = pick(rng, sorted(e[1]))
            e[1][key] = " ".join(scaled(word, float(pick(rng, FACTORS))) for word in e[1][key].split())
    elif how <= 4 and at[1]:
        key = pick(rng, sorted(at[1]))
        old, new = at[1][key], name(rng)
        for e in everything if chance(rng, 0.7) else [at]:  # in every place that refers to it, or in one alone
            e[1] = {k: new if v == old and k in ("name", "link", "joint", key) else v for k, v in e[1].items()}
    elif how == 5 and at[1]:
        del at[1][pick(rng, sorted(at[1]))]
    elif how == 6 and at[2]:
        at[2].pop(int(rng.integers(len(at[2]))))
    elif how == 7 and at[2]:
        at[2].append(pick(rng, at[2]))
    elif how == 8:
        at[0] = str(pick(rng, ["Link", "xacro:macro", "a:link", "robot", "joint", "link", "gazebo", "transmission"]))
    elif how == 9 and joints:
        pick(rng, joints)[1]["type"] = str(pick(rng, KINDS + ODD_KINDS))
    elif how == 10 and joints:
        ends = [e for e in pick(rng, joints)[2] if e[0] in ("parent", "child")]
        if ends:
            pick(rng, ends)[1]["link"] = str(pick(rng, ["base", "link0", "link1", "nowhere", "flange0"]))
    elif how == 11 and joints:
        mimic = {"joint": str(pick(rng, ["joint0", "joint1", "nowhere", "weld0"])), "multiplier": number(rng)}
        pick(rng, joints)[2].append(["mimic", mimic, []])
    elif how == 12:
        at[1][str(pick(rng, ["xmlns", "xmlns:a", "xml:base", "extra", "name", "type", "version"]))] = name(rng)
    elif how == 13:
        at[2].append(pick(rng, [["gazebo", {}, [["plugin", {"name": INJECTED}, []]]], ["link", {"name": "lone"}, []]]))
    elif how == 14 and chance(rng, 0.1):
        at[1] |= {f"a{k}": "1" for k in range(int(rng.choice([100, 50_000])))}
    elif how == 15 and chance(rng, 0.1):
        for _ in range(int(rng.choice([50, 300, 3_000]))):
            root[2] = [["robot", {}, root[2]]]


def text(rng: Rng, root: Element) -> str:
    """The elements as XML, mostly without the characters that XML refuses, or no name would get past the parser."""

    def attribute(value: str) -> str:
        if not chance(rng, 0.02):
            value = "".join(c for c in value if c >= " " or c in "\t\n\r")
        return quoteattr(value, {"\n": "&#10;", "\r": "&#13;", "\t": "&#9;"})

    pieces: list[str] = []
    waiting: list[Element | str] = [root]
    while waiting:  # no recursion: some are nested deeper than Python goes
        e = waiting.pop()
        if isinstance(e, str):
            pieces.append(e)
            continue
        pieces.append(f"<{e[0]}" + "".join(f" {key}={attribute(value)}" for key, value in e[1].items()) + ">")
        if chance(rng, 0.001):
            pieces.append(str(pick(rng, ["<!-- -->", "<![CDATA[x]]>", "<?p i?>", escape(INJECTED), "&none;", "text"])))
        waiting += [f"</{e[0]}>\n", *reversed(e[2])]
    return "".join(pieces)


def encoded(rng: Rng, body: str) -> bytes:
    """As bytes, mostly UTF-8; with a declaration that may be wrong, and entities that swell."""
    odd = ["utf-8-sig", "utf-16", "latin-1", "gbk", "utf-32", "ascii"]
    encoding = "utf-8" if chance(rng, 0.94) else str(pick(rng, odd))
    said = encoding if chance(rng, 0.9) else str(pick(rng, ["utf-8", "gbk", "klingon", "", "ascii", "utf-7"]))
    declaration = f'<?xml version="1.0" encoding="{said}"?>\n' if chance(rng, 0.5) or encoding != "utf-8" else ""
    if chance(rng, 0.05):
        declaration = str(pick(rng, ['<?xml version="0.0"?>', '<?xml version="1.1"?>', "<?xml?>", "\n\n<?xml ?>"]))
    if chance(rng, 0.02):
        levels = "".join(f'<!ENTITY e{k + 1} "{f"&e{k};" * 10}">' for k in range(9))
        declaration += pick(
            rng,
            [
                f'<!DOCTYPE robot [<!ENTITY e0 "a">{levels}]>',
                '<!DOCTYPE robot [<!ENTITY e9 SYSTEM "/dev/zero">]>',
                '<!DOCTYPE robot SYSTEM "http://localhost:1/x.dtd">',
            ],
        )
        body = body.replace('name="r"', 'name="&e9;"', 1)
    return (declaration + body).encode(encoding, errors="surrogatepass" if "utf" in encoding else "replace")


def urdf(rng: Rng, corpus: Sequence[bytes]) -> bytes:
    """One file: generated in four of five, else one of the corpus with some bytes changed."""
    if chance(rng, 0.12):
        return mutate_bytes(rng, pick(rng, corpus), pick(rng, corpus))
    most = (
        400 if chance(rng, 0.003) else 40 if chance(rng, 0.01) else int(rng.choice([0, 1, 1, 2, 2, 2, 3, 3, 4, 6, 7]))
    )
    root = sound(rng, most)
    for _ in range(int(rng.choice([0, 0, 1, 1, 1, 2, 3]))):
        disturb(rng, root)
    made = encoded(rng, text(rng, root))
    return mutate_bytes(rng, made) if chance(rng, 0.03) else made


def mbar(rng: Rng) -> str:
    """What is given as M̄: mostly one small number for all joints."""
    if chance(rng, 0.03):
        return ",".join(number(rng) for _ in range(int(rng.integers(1, 5))))
    return repr(float(10.0 ** rng.uniform(-4.0, 1.0)))


def options(rng: Rng) -> list[str]:
    """Some of the options that every question about an arm takes."""
    found: list[str] = []
    for key, values in (
        ("--payload", ["1", "0:2", "0", "1e-9", "-1", "nan", "1e300", "2:1"]),
        ("--armature", ["0.1", "0.1:0.2", "0", "1,2", "-1", "1e-300"]),
        ("--lock", ["joint0=0.3", "joint1=0.1,0.5", "joint1=free", "nowhere=1", "joint0=1e300", "weld0=1"]),
        ("--gravity", ["0,0,9.81", "0,0,0", "9.81,0,0", "1", "nan,0,0"]),
        ("--box", ["joint0=-1:1", "joint0=0:0", "joint0=-9:9", "joint1=-1e300:1e300", "nowhere=0:1", "joint0=1:0"]),
    ):
        if chance(rng, 0.07):
            found += [key, str(pick(rng, values))]
    return found


def make(rng: Rng, folder: Path, corpus: Sequence[bytes]) -> list[str]:
    """Write a URDF into the folder; the command that is to read it.

    Args:
        rng: Where all chance comes from.
        folder: An empty folder, which will be the working directory.
        corpus: Sound URDFs.
    """
    path = "arm.urdf" if chance(rng, 0.97) else str(pick(rng, ["arm.xml", "-a.urdf", "[b].urdf", "a b\n.urdf"]))
    (folder / path).write_bytes(urdf(rng, corpus))
    if chance(rng, 0.01):
        path = str(pick(rng, ["/dev/zero", "/dev/null", ".", "", "nowhere.urdf", "arm.urdf/x", "\x00"]))
    command = str(rng.choice(["verify", "agree", "stability", "design"], p=[0.68, 0.15, 0.15, 0.02]))
    words = [command, *options(rng)]
    if command in ("verify", "stability"):
        words += ["--mbar", mbar(rng)]
    if command in ("verify", "design"):
        words += ["--condition", "weighted"] if chance(rng, 0.4) else []
        words += ["--report", str(pick(rng, ["page.html", "page.md"]))] if chance(rng, 0.04) else []
    if command == "verify":
        words += ["--samples", "64"]
        words += ["--certify", "--budget", "0.2", "--certificate", "proof.cert"] if chance(rng, 0.06) else []
    if command == "agree":
        words = [w for pair in zip(words[1::2], words[2::2], strict=True) if pair[0] != "--box" for w in pair]
        words.insert(0, command)
    if command == "stability":
        words += ["--ks", "10", "--beta", number(rng) if chance(rng, 0.1) else "10", "--period", "0.001"]
    return [*words, *(["--json"] if chance(rng, 0.7) else []), "--", path]
