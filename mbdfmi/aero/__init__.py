"""Rotors in steady wind by blade elements: tables for the wind's rotors of scenes."""
