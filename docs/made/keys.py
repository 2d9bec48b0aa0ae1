"""Every key of every kind of file, from its JSON schema."""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from sequences import schema
from swimlab.footage.shot import shot_schema
from swimlab.gate.rules import gate_schema
from swimlab.render.catalogue import brdf_settings, technique_settings
from swimlab.sweep.file import sweep_schema

Node = Mapping[str, Any]

KINDS: dict[str, tuple[Callable[[], Node], str]] = {
    "sequence": (
        lambda: schema(technique_settings()),
        "What is rendered; [the guide](../guides/sequences.md) has examples. Lengths are metres, angles degrees.",
    ),
    "shot": (shot_schema, "Anyone's frames under several builds; [the guide](../guides/shots.md) has an example."),
    "gate": (gate_schema, "What scores may cost; [the guide](../guides/gate.md) has an example."),
    "sweep": (sweep_schema, "A grid of settings; [the guide](../guides/sweeps.md) has an example."),
}
BOUNDS = {"minimum": "≥ {}", "exclusiveMinimum": "> {}", "maximum": "≤ {}", "exclusiveMaximum": "< {}"}


def page(kind: str) -> str:
    """The page of a kind of file, a table of keys a TOML table."""
    made, words = KINDS[kind]
    root = made()
    blocks = [
        f"# {kind.capitalize()} files",
        f"{words} The page is made from `swimlab schema {kind}`, which editors take for completion and checks. A key "
        "that is not here is an error, with a hint at the nearest one.",
        *_sections("", root, root.get("$defs", {})),
    ]
    if kind == "sequence":
        for name, model in brdf_settings().items():
            node = model.model_json_schema()
            if node.get("properties"):
                blocks += _sections(f'scene.material.parameters], with brdf = "{name}"', node, node.get("$defs", {}))
    return "\n\n".join(blocks) + "\n"


def _sections(path: str, node: Node, shared: Node) -> Iterator[str]:
    """A table's heading and keys, then those of the tables in it."""
    if path:
        yield f"## `[{path}`" if "]," in path else f"## `[{path}]`"
    if path and node.get("description"):
        yield str(node["description"])
    rows, below = [], []
    for key, value in node.get("properties", {}).items():
        inner = f"{path}.{key}" if path else key
        tables = list(_tables(inner, value, shared))
        below += tables
        if not tables:
            default = "**needed**" if key in node.get("required", ()) else _default(value)
            rows.append(f"| `{key}` | {_type(value, shared)} | {default} | {_words(value)} |")
    if rows:
        yield "\n".join(["| key | what it takes | default | what it is |", "| --- | --- | --- | --- |", *rows])
    for inner, table in below:
        yield from _sections(inner, table, shared)


def _tables(path: str, value: Node, shared: Node) -> Iterator[tuple[str, Node]]:
    """The tables that a key may be, with their paths; none where it is a value."""
    told = {"description": value["description"]} if "description" in value else {}
    if "$ref" in value:
        yield path, _resolved(value, shared) | told
    for option in (*value.get("anyOf", ()), *value.get("oneOf", ())):
        if "$ref" in option:
            table = _resolved(option, shared)
            kind = table.get("properties", {}).get("kind", {}).get("const")
            yield (f'{path}], with kind = "{kind}"', table) if kind else (path, table | told)
    if "$ref" in value.get("items", {}):
        yield f"[{path}]", _resolved(value["items"], shared)
    if isinstance(value.get("additionalProperties"), dict) and "$ref" in value["additionalProperties"]:
        yield f"{path}.NAME", _resolved(value["additionalProperties"], shared)
    for name, table in value.get("properties", {}).items():
        if "$ref" in table:
            yield f"{path}.{name}", _resolved(table, shared)


def _resolved(value: Node, shared: Node) -> dict[str, Any]:
    return dict(shared[value["$ref"].removeprefix("#/$defs/")])


def _type(value: Node, shared: Node) -> str:
    """What a key takes, in words."""
    if "const" in value:
        return f"`{_toml(value['const'])}`"
    if "enum" in value:
        return ", ".join(f"`{_toml(each)}`" for each in value["enum"])
    if "anyOf" in value:
        return ", or ".join(_type(each, shared) for each in value["anyOf"] if each.get("type") != "null")
    bounds = [words.format(f"{value[name]:.12g}") for name, words in BOUNDS.items() if name in value]
    match value.get("type"):
        case "array":
            parts = value.get("prefixItems")
            if parts:
                return f"[{', '.join(_type(part, shared) for part in parts)}]"
            return f"list of {_type(value.get('items', {}), shared)}"
        case "object":
            return "table"
        case "integer":
            return " ".join(["whole number", ", ".join(bounds)]).strip()
        case "number":
            return " ".join(["number", ", ".join(bounds)]).strip()
        case "string":
            return "text"
        case "boolean":
            return "`true`, `false`"
        case _:
            return "value"


def _default(value: Node) -> str:
    given = value.get("default")
    return "" if given is None else f"`{_toml(given)}`"


def _toml(value: Any) -> str:
    match value:
        case bool():
            return str(value).lower()
        case str():
            return f'"{value}"'
        case list():
            return f"[{', '.join(map(_toml, value))}]"
        case dict():
            return "{}"
        case _:
            return f"{value:g}" if isinstance(value, float) and abs(value) < 1e5 else str(value)


def _words(value: Node) -> str:
    text = str(value.get("description", ""))
    return text.replace("|", "\\|").replace("[", "\\[")
