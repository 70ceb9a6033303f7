"""Scenes and runs to look at: an animated GLB (glTF 2) as the one intermediate, a page around it,
pictures.
"""
