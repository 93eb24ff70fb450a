#!/usr/bin/env python3
"""What DuckDB and polars see in the results of a sweep, as JSON: rows, types of some columns, the first row."""
import json
import sys

COLUMNS = ["cycles", "time_ms", "identical", "machine", "block"]
SHOWN = ["cycles", "time_ms", "identical", "l1", "block"]


def with_duckdb(path):
    import duckdb

    own = duckdb.read_parquet(path)
    names = {"BIGINT": "integer", "DOUBLE": "float", "BOOLEAN": "flag", "VARCHAR": "text"}
    types = dict(zip(own.columns, map(str, own.types)))
    first = duckdb.sql(f"select {', '.join(SHOWN)} from own order by point limit 1").fetchall()[0]
    return {
        "rows": duckdb.sql("select count(*) from own").fetchall()[0][0],
        "types": [names.get(types[name], types[name]) for name in COLUMNS],
        "first": dict(zip(SHOWN, first)),
    }


def with_polars(path):
    import polars

    table = polars.read_parquet(path)
    names = {"Int64": "integer", "Float64": "float", "Boolean": "flag", "String": "text"}
    types = [str(table.schema[name]) for name in COLUMNS]
    return {
        "rows": table.height,
        "types": [names.get(own, own) for own in types],
        "first": table.sort("point").select(SHOWN).row(0, named=True),
    }


def main():
    found = {}
    for name, read in (("duckdb", with_duckdb), ("polars", with_polars)):
        try:
            found[name] = read(sys.argv[1])
        except ImportError:
            print(f"python3 has no {name}: pip install {name}", file=sys.stderr)
    print(json.dumps(found))
    return 0 if found else 77


sys.exit(main())
