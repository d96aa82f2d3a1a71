"""Recordings of many robots, processed every day: which robot is faulty, which place of the floor is bad.

The path of a recording: `batch` finds it in a store, `segments` and `features` reduce it to a few small
linear problems, which are written as Parquet; `judge` reads them, fits robots and floor together (`model`),
and makes the daily report (`report`), which `report_store` writes and reads. `hall` simulates a fleet with
known truth.

Words of the file formats, of REST and of hall.toml stay as they were published: `sick` is a faulty robot,
`night` and `nights` are daily reports, `asked` is a mismatch that triage repeats, `ways` and `way` are
segments (in `recordings`: the distance driven), `listed` is a robot that the report names as faulty.
"""
