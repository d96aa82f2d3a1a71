"""The reference of the REST interface, from the document that the service itself serves."""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from mkdocs.structure.files import File

from omnimate.service.app import create_app
from omnimate.service.routes.common import ALWAYS
from omnimate.service.settings import Settings

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import Files

HEAD = """# REST

Every call of `omnimate serve`, from its OpenAPI document (`/openapi.json`). The conventions (units, errors,
idempotency, keys, lists), the states of a session and the stream are in
[REST, conventions and states](service.md). [My fleet](../how-to/fleet.md) shows the calls in use.

Any call may be answered by a problem (`application/problem+json`, the [Problem](#problem) object) with one of
the statuses STATUSES.
""".replace("STATUSES", ", ".join(map(str, ALWAYS)))
SCHEMA = "#/components/schemas/"


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the page of all calls."""
    parts: Any = SimpleNamespace(settings=Settings())
    document = create_app(parts).openapi()
    files.append(File.generated(config, "reference/rest.md", content="".join(_page(document))))
    return files


def _page(document: Mapping[str, Any]) -> Iterator[str]:
    yield HEAD
    calls = [(verb, path, call) for path, verbs in document["paths"].items() for verb, call in verbs.items()]
    tags = list(dict.fromkeys(_tag(call) for _, _, call in calls))
    for tag in tags:
        yield f"\n## {tag.capitalize()}\n\n"
        for method, path, call in calls:
            if _tag(call) == tag:
                yield from _call(method, path, call)
    yield "\n## Objects\n\n"
    for name, schema in document["components"]["schemas"].items():
        yield from _object(name, schema)


def _tag(call: Mapping[str, Any]) -> str:
    return str(call.get("tags", ["service"])[0])


def _call(method: str, path: str, call: Mapping[str, Any]) -> Iterator[str]:
    yield f"### {method.upper()} `{path}`\n\n{call.get('description', call.get('summary', '')).strip()}\n\n"
    body = call.get("requestBody", {}).get("content", {})
    for kind, content in body.items():
        yield f"- Body: `{kind}`, {_type(content.get('schema', {}))}\n"
    for status, answer in call["responses"].items():
        if status.startswith("2"):
            contents = answer.get("content", {}).items()
            kinds = ", ".join(f"`{kind}` {_type(content.get('schema', {}))}" for kind, content in contents)
            yield f"- Answer {status}: {kinds or 'no content'}\n"
    parameters = call.get("parameters", [])
    if parameters:
        yield "\n| parameter | in | type | what it is |\n| --- | --- | --- | --- |\n"
        for each in parameters:
            schema = each.get("schema", {})
            needed = " (required)" if each.get("required") and each["in"] != "path" else ""
            text = _cell(each.get("description", "")) + _default(schema)
            yield f"| `{each['name']}` | {each['in']}{needed} | {_type(schema)} | {text} |\n"
    yield "\n"


def _object(name: str, schema: Mapping[str, Any]) -> Iterator[str]:
    yield f"### {_shown(name)} {{ #{_anchor(name)} }}\n\n{_cell(schema.get('description', ''))}\n\n"
    fields = schema.get("properties", {})
    if not fields:
        yield f"{_type(schema)}\n\n"
        return
    required = schema.get("required", ())
    yield "| field | type | what it is |\n| --- | --- | --- |\n"
    for field, about in fields.items():
        text = f"{_cell(about.get('description', ''))}{_default(about)}"
        optional = "" if field in required or "default" in about else " May be left out."
        yield f"| `{field}` | {_type(about)} | {text}{optional} |\n"
    yield "\n"


def _type(schema: Mapping[str, Any]) -> str:
    """Return a schema in a few words, with links to the objects that it names."""
    if "$ref" in schema:
        name = schema["$ref"].removeprefix(SCHEMA)
        return f"[{_shown(name)}](#{_anchor(name)})"
    for several in ("anyOf", "oneOf"):
        if several in schema:
            return " or ".join(dict.fromkeys(_type(each) for each in schema[several]))
    if "enum" in schema or "const" in schema:
        return ", ".join(f"`{value}`" for value in schema.get("enum", [schema.get("const")]))
    return _container(schema)


def _container(schema: Mapping[str, Any]) -> str:
    kind, values = schema.get("type", "any"), schema.get("additionalProperties")
    if kind == "array" and "items" in schema:
        return f"list of {_type(schema['items'])}"
    if kind == "object" and isinstance(values, dict):
        return f"object of {_type(values)}"
    return str(kind) + _range(schema)


def _range(schema: Mapping[str, Any]) -> str:
    low, high = schema.get("minimum"), schema.get("maximum")
    if low is not None and high is not None:
        return f", {low:g} to {high:g}"
    return f", {low:g} or more" if low is not None else ""


def _default(schema: Mapping[str, Any]) -> str:
    default = schema.get("default")
    return "" if default is None else f" Default: `{default}`."


def _shown(name: str) -> str:
    return name.replace("_", " ").strip()


def _anchor(name: str) -> str:
    return name.lower().replace("_", "-").strip("-")


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|").replace("<", "&lt;")
