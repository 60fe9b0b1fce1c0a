"""An examination: the questions of certify as a folder of files, for machines without Python, and its marks.

`write` has every check put its questions to a `recording.Recorder`, which keeps them and judges nothing; `folder` lays
them down with runners in MATLAB, C++ and R. What comes back is read by `answers` as a file of somebody unknown, and a
`replaying.Replay` gives it to the same checks, which do not know the difference. What is right follows from the seed
and is in no file. `pack` does likewise with the golden values.
"""
