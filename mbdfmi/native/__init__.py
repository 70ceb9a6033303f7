"""The compiled kernels as a library.

For which platforms (`platforms`), of what, kept where (`sources`), found, made and called (`library`).
What is in it is the business of kernels/, and how it is made that of export/.
"""
