"""Reads a stage of OpenUSD as edits of an Alabaster scene. Needs `pxr` 24.8 or later; nothing else beyond Python."""
