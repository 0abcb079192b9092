"""The subcommands, one module each with ``main(arguments) -> exit code``; imported when called, to start fast."""

EXIT_OK, EXIT_CRASH, EXIT_INPUT, EXIT_INTERRUPTED = 0, 1, 2, 130

COMMANDS = ("dashboard", "doctor")
