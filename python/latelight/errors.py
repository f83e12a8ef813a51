"""The kinds of errors. Each message is one sentence."""


class LatelightError(Exception):
    """Base of all errors; `exit_code` is that of the command line (docs/exit-codes.md)."""

    exit_code = 1


class UsageError(LatelightError, ValueError):
    """An invalid argument, option or edit."""

    exit_code = 2


class ArgumentTypeError(UsageError, TypeError):
    """An argument of the wrong type, or an unknown argument."""


class InputError(LatelightError):
    """A file that is missing, broken, or requires an unsupported feature."""

    exit_code = 3


class NoDeviceError(LatelightError):
    """No Vulkan 1.3 device, or not the requested one."""

    exit_code = 4


class DeviceLostError(LatelightError):
    """The device was lost: its driver stopped it. A new renderer may work."""

    exit_code = 5


class OutOfMemoryError(LatelightError, MemoryError):
    """The device or the machine has no memory left, or the scene exceeds a limit of the device."""

    exit_code = 7
