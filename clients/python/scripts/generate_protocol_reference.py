"""Writes the reference of messages in docs/protocol.md from the schema.

`python scripts/generate_protocol_reference.py`. What stands between the two marks of the page is this script's; a test
compares.
"""

import re
from dataclasses import dataclass, field
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[3]
SCHEMA = REPOSITORY / "protocol" / "proto" / "sturz" / "v1"
PAGE = REPOSITORY / "docs" / "protocol.md"
BEGIN, END = "<!-- reference: begin -->", "<!-- reference: end -->"
FILES = ("data", "command", "status")

_FIELD = re.compile(r"(?:(repeated|optional) )?([\w.]+) (\w+) = (\d+);")
_VALUE = re.compile(r"(\w+) = (\d+);")


@dataclass
class Entry:
    """A field of a message, or a value of an enum."""

    name: str
    number: int
    comment: str
    type: str = ""


@dataclass
class Block:
    """A message or an enum."""

    kind: str
    name: str
    comment: str
    entries: list[Entry] = field(default_factory=list)


def parse(text: str) -> list[Block]:
    """Messages and enums of a file, in order. The schema nests nothing but oneofs."""
    blocks: list[Block] = []
    comment: list[str] = []
    oneof = ""
    for line in map(str.strip, text.splitlines()):
        if line.startswith("//"):
            comment.append(line.removeprefix("//").strip())
            continue
        said, comment = "\n".join(" ".join(part.split("\n")) for part in "\n".join(comment).split("\n\n")).strip(), []
        if opened := re.match(r"(message|enum) (\w+) \{(\})?", line):
            blocks.append(Block(opened[1], opened[2], said))
        elif opened := re.match(r"oneof (\w+) \{", line):
            oneof = opened[1]
        elif line == "}":
            oneof = ""
        elif blocks and blocks[-1].kind == "enum" and (value := _VALUE.fullmatch(line)):
            blocks[-1].entries.append(Entry(value[1], int(value[2]), said))
        elif blocks and (of := _FIELD.fullmatch(line)):
            kind = f"{of[1]} {of[2]}" if of[1] else f"{of[2]}, one of `{oneof}`" if oneof else of[2]
            blocks[-1].entries.append(Entry(of[3], int(of[4]), said, kind))
    return blocks


def reference() -> str:
    """The whole reference, Markdown."""
    lines: list[str] = []
    for name in FILES:
        lines += [f"### {name}.proto", ""]
        for block in parse((SCHEMA / f"{name}.proto").read_text()):
            lines += [f"#### {block.kind} {block.name}", ""]
            if block.comment:
                lines += [_cell(block.comment).replace("\n", "\n\n"), ""]
            if not block.entries:
                continue
            if block.kind == "enum":
                lines += ["| number | value | meaning |", "|---:|---|---|"]
                lines += [f"| {each.number} | `{each.name}` | {_cell(each.comment)} |" for each in block.entries]
            else:
                lines += ["| number | field | type | meaning |", "|---:|---|---|---|"]
                lines += [
                    f"| {each.number} | `{each.name}` | {each.type} | {_cell(each.comment)} |" for each in block.entries
                ]
            lines.append("")
    return "\n".join(lines)


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("<", "&lt;")


def page(text: str) -> str:
    """The page with the reference of now."""
    before, rest = text.split(BEGIN)
    _, after = rest.split(END)
    return f"{before}{BEGIN}\n\n{reference()}\n{END}{after}"


if __name__ == "__main__":
    PAGE.write_text(page(PAGE.read_text()))
