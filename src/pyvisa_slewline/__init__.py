"""The PyVISA backend `slewline`.

PyVISA finds it by the name of this package: pyvisa.ResourceManager("@slewline").
"""

from slewline.testing.for_visa import SlewlineVisaLibrary as WRAPPER_CLASS

__all__ = ["WRAPPER_CLASS"]
