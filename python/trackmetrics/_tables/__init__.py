"""Tables from files as people have them: packed or not, in any encoding, with any delimiter.

``opening`` finds the text in a file, ``delimited`` and ``json_lines`` turn text into columns,
``headings`` matches their names, ``times`` turns what stands for a time into seconds. Columns are
NumPy arrays, or :class:`Ragged` where rows have lists of different lengths. Polars reads and writes
where it is installed (the extra ``files``); the small readers that do without it are many times
slower.
"""
