"""Many missions: solved one by one, on this machine or on a cluster, each a row of a table that loses nothing.

`inputs` makes a `SweepJob` of what a person writes, `run` cuts it into batches, sends them to `workers` or a
`cluster`, keeps what comes back (`store`) and tells what it amounts to (`summary`, `portfolio`).
"""
