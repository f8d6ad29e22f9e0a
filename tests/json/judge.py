"""Gives every document of cases.json, and every scene file, to the published schema: it must refuse what the
reader refuses, but for what only the reader can see. Usage: judge.py SCHEMA CASES SCENE..."""
import json
import sys

import jsonschema


def load(path):
    with open(path, encoding="utf-8") as file:
        return json.load(file)


schema = load(sys.argv[1])
jsonschema.Draft7Validator.check_schema(schema)
validator = jsonschema.Draft7Validator(schema)
failures = 0
cases = load(sys.argv[2])
for place, case in enumerate(cases):
    expected = "message" not in case or case.get("onlyReader", False)
    if validator.is_valid(case["document"]) != expected:
        failures += 1
        print(f"case {place}: the schema should {'accept' if expected else 'refuse'} {json.dumps(case)}")
for path in sys.argv[3:]:
    for error in validator.iter_errors(load(path)):
        failures += 1
        print(f"{path}: {error.json_path}: {error.message}")
print(f"{len(cases)} documents and {len(sys.argv) - 3} scenes: {failures} judged wrong")
sys.exit(1 if failures else 0)
