"""Daily evaluation of the recordings of many robots: faulty robots, and bad places of the floor.

`batch` processes each recording of a store: `segments` and `features` reduce it to a few small linear
problems, which are written as Parquet. `judge` reads these, fits robots and floor together (`model`), and
makes the daily report (`report`), which `report_store` writes and reads. `hall` simulates a fleet with known
truth.

File formats, REST and hall.toml use these published words: `sick` is a faulty robot, `night` and `nights` are
daily reports, `asked` is a mismatch that triage repeats, `ways` and `way` are segments (in `recordings`: the
distance driven), `listed` is a robot that the report names as faulty, `numbers` are quantities of a robot.
"""
