"""SCons of PyPI in the place of PlatformIO's own package of it."""

from SCons.Script import main

main()
