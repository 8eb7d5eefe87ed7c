"""Values that a JSON Schema allows, for the keywords of the published schema of scene files, without the library."""

from random import Random
from typing import Any

NICE = [0, 1, -1, 2, 0.5, 3, -2, 0.25, 10, 45, 90, 30, 0.1, 1.5, 5, 180]
WILD = [
    1e100,
    -1e100,
    1e-100,
    1e101,
    1e-101,
    1e300,
    float("inf"),
    float("-inf"),
    10**400,
    1e50,
    -1e50,
    1e-50,
    1e16,
    -0.0,
    360,
    1e8,
    7e7,
]
NAMES = [
    "ball",
    "wheel",
    "bore",
    "balls.npy",
    "balls.csv",
    "red",
    "steelblue",
    "#ff8800",
    "brass",
    "a",
    "no",
    "zero.npy",
    "pipe.npy",
]
DEEPEST = 9


class Generator:
    """Random values of one schema."""

    def __init__(self, random: Random, schema: dict[str, Any]) -> None:
        self.random, self.root = random, schema
        self.wild = random.choice([0.0, 0.0, 0.02, 0.2])
        self.decades = random.choice([0, 0, 0, 3, 20, 50, 99])  # numbers between 10^-decades and 10^decades

    def value(self, schema: Any, depth: int = 0) -> Any:
        """Return a value that the schema allows."""
        if "$ref" in schema:
            found = self.root
            for step in schema["$ref"].removeprefix("#/").split("/"):
                found = found[step]
            return self.value(found, depth)
        if "const" in schema:
            return schema["const"]
        if "enum" in schema:
            return self.random.choice(schema["enum"])
        if "anyOf" in schema:
            return self.value(self._alternative(schema["anyOf"], depth), depth)
        kinds = schema.get("type", ["number", "string", "null"])
        return self._typed(self.random.choice(kinds) if isinstance(kinds, list) else kinds, schema, depth)

    def _alternative(self, options: list[Any], depth: int) -> Any:
        """Return any of the alternatives, and deep down one that ends soon."""
        if depth > DEEPEST:
            simple = [option for option in options if option.get("type") not in (None, "object", "array")]
            named = [option for option in options if option.get("$ref", "").endswith(("Sphere", "Plane", "Box"))]
            return self.random.choice(simple or named or options)
        rare = [option for option in options if option.get("$ref", "").endswith("template")]  # few of these load
        return self.random.choice(
            rare if rare and self.random.random() < 0.05 else [o for o in options if o not in rare]
        )

    def _typed(self, kind: str, schema: dict[str, Any], depth: int) -> Any:
        if kind == "object":
            return self._object(schema, depth)
        if kind == "array":
            least, most = schema.get("minItems", 0), schema.get("maxItems", 4 if depth < DEEPEST else 1)
            return [
                self.value(schema.get("items", {}), depth + 1)
                for _ in range(self.random.randint(least, max(least, most)))
            ]
        if kind == "number":
            if self.random.random() < self.wild:
                return self.random.choice(WILD)
            if self.decades and self.random.random() < 0.5:
                return self.random.choice([1, 1, 1, -1]) * 10 ** self.random.uniform(-self.decades, self.decades)
            return self.random.choice(NICE)
        if kind == "integer":
            return self.random.randint(-3, 9)
        if kind == "boolean":
            return self.random.random() < 0.5
        return self.random.choice(NAMES) if kind == "string" else None

    def _object(self, schema: dict[str, Any], depth: int) -> dict[str, Any]:
        required = schema.get("required", ())
        share = 0.6 if depth < DEEPEST - 2 else 0.1
        result = {
            name: self.value(inner, depth + 1)
            for name, inner in schema.get("properties", {}).items()
            if name in required or self.random.random() < share
        }
        if isinstance(schema.get("additionalProperties"), dict):
            for name in self.random.sample(["ball", "wheel", "bore", "brass", "red"], self.random.randint(0, 3)):
                result[name] = self.value(schema["additionalProperties"], depth + 1)
        return result
