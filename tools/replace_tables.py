#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Replaces tables of a results file by those of others, where they are measured anew by themselves.

    svocl bench e7 --scenes atrium,sponza.obj -o new.json
    tools/replace_tables.py docs/results.json new.json

Rows of a table that several of the new files have follow each other. Tables that are not there yet follow those that
stand before them in the new file. `svocl report --from FILE -o FOLDER` writes the result in the usual layout.
"""

import argparse
import json


def load(path):
    with open(path, encoding="utf-8") as file:
        return json.load(file)


def join(documents, wanted):
    """The tables of the new files, by ID."""
    tables = {}
    for document in documents:
        for table in document["tables"]:
            if wanted is not None and table["id"] not in wanted:
                continue
            first = tables.setdefault(table["id"], table)
            if first["columns"] != table["columns"]:
                raise SystemExit(f"{table['id']}: the files have different columns")
            if first is not table:
                first["rows"] += table["rows"]
    return tables


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old", help="the results file, which is written")
    parser.add_argument("new", nargs="+", help="results files")
    parser.add_argument("--tables", type=lambda text: text.split(","), help="take these IDs alone, with commas between")
    given = parser.parse_args()
    old = load(given.old)
    documents = [load(path) for path in given.new]
    facts = {fact: None for document in documents for fact in document["machine"].items() if fact[0] != "date"}
    for fact, value in facts:
        if old["machine"].get(fact) != value:
            print(f"another machine: {fact} is {value}, was {old['machine'].get(fact)}")
    place = len(old["tables"])
    for table in join(documents, given.tables).values():
        known = [i for i, other in enumerate(old["tables"]) if other["id"] == table["id"]]
        if known:
            place = known[0]
            old["tables"][place] = table
        else:
            old["tables"].insert(place, table)
        place += 1
        print(f"{'replaced' if known else 'added'}: {table['id']}, {len(table['rows'])} rows")
    with open(given.old, "w", encoding="utf-8") as file:
        json.dump(old, file)


if __name__ == "__main__":
    main()
