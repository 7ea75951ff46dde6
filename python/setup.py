"""The wheel holds liblimber.so: it is for one kind of machine, and for any Python 3."""

from setuptools import setup
from setuptools.dist import Distribution


class WithLibrary(Distribution):
    def has_ext_modules(self):
        return True


setup(distclass=WithLibrary)
