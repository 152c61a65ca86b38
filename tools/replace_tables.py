#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Replaces tables of a results file by those of another one, where they are measured anew by themselves.

    svocl bench e7 --scenes atrium,sponza.obj -o new.json
    tools/replace_tables.py docs/results.json new.json

Tables that are not there yet follow those that stand before them in the new file. `svocl report --from FILE -o FOLDER`
writes the result in the usual layout.
"""

import json
import sys


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    old_path, new_path = sys.argv[1:]
    with open(old_path, encoding="utf-8") as file:
        old = json.load(file)
    with open(new_path, encoding="utf-8") as file:
        new = json.load(file)
    for fact, value in new["machine"].items():
        if fact != "date" and old["machine"].get(fact) != value:
            print(f"another machine: {fact} is {value}, was {old['machine'].get(fact)}")
    place = len(old["tables"])
    for table in new["tables"]:
        known = [i for i, other in enumerate(old["tables"]) if other["id"] == table["id"]]
        if known:
            place = known[0]
            old["tables"][place] = table
        else:
            old["tables"].insert(place, table)
        place += 1
        print(f"{'replaced' if known else 'added'}: {table['id']}, {len(table['rows'])} rows")
    with open(old_path, "w", encoding="utf-8") as file:
        json.dump(old, file)


if __name__ == "__main__":
    main()
