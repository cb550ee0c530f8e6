# SPDX-License-Identifier: Apache-2.0
"""The generated reference and schema are up to date, and every scene of ours has only keys that the schema knows."""
import glob
import json
import subprocess
import sys

program, source = sys.argv[1:3]
for what, name in (("markdown", "scene-reference.md"), ("schema", "scene.schema.json")):
    made = subprocess.run([program, what], check=True, capture_output=True, text=True).stdout
    with open("%s/docs/%s" % (source, name), encoding="utf-8") as f:
        if f.read() != made:
            sys.exit("docs/%s is out of date: build the target scene_reference_update" % name)
schema = json.loads(made)


def check(value, s, where):
    """As much of JSON Schema as the schema uses; an error text or None."""
    if "$ref" in s:
        return check(value, schema["$defs"][s["$ref"].rsplit("/", 1)[1]], where)
    for word in ("oneOf", "anyOf"):
        if word in s:
            errors = [check(value, option, where) for option in s[word]]
            fits = errors.count(None)
            return None if fits == 1 or (word == "anyOf" and fits) else "%s fits %d options: %s" % (where, fits, errors)
    if "const" in s or "enum" in s:
        return None if value in s.get("enum", [s.get("const")]) else "%s is %r" % (where, value)
    kinds = {"object": dict, "array": list, "string": str, "boolean": bool, "number": (int, float), "integer": (int, float)}
    if not isinstance(value, kinds[s["type"]]) or (isinstance(value, bool) and s["type"] != "boolean"):
        return "%s is %r, not %s" % (where, value, s["type"])
    if isinstance(value, dict):
        for key in s.get("required", []):
            if key not in value:
                return "%s has no %s" % (where, key)
        for key, entry in value.items():
            sub = s.get("properties", {}).get(key, s["additionalProperties"])
            error = "%s: unknown key %s" % (where, key) if sub is False else check(entry, sub, "%s.%s" % (where, key))
            if error:
                return error
    if isinstance(value, list):
        if not s.get("minItems", 0) <= len(value) <= s.get("maxItems", 1 << 60):
            return "%s has %d entries" % (where, len(value))
        for i, entry in enumerate(value):
            error = check(entry, s.get("items", {"anyOf": [{"const": entry}]}), "%s[%d]" % (where, i))
            if error:
                return error
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        if not (s.get("minimum", -1e300) <= value <= s.get("maximum", 1e300)
                and s.get("exclusiveMinimum", -1e300) < value < s.get("exclusiveMaximum", 1e300)):
            return "%s is %r, out of range" % (where, value)
    return None


for path in sorted(glob.glob(source + "/scenes/*.json")):
    with open(path, encoding="utf-8") as f:
        error = check(json.load(f), schema, path)
    if error:
        sys.exit(error)
