"""``trackmetrics completion SHELL``: the completion script of a shell."""

import click

from trackmetrics.cli._output import Command

SHELLS = ("bash", "zsh", "fish")


@click.command(
    cls=Command,
    examples="""
    eval "$(trackmetrics completion bash)"              in ~/.bashrc
    eval "$(trackmetrics completion zsh)"               in ~/.zshrc
    trackmetrics completion fish > ~/.config/fish/completions/trackmetrics.fish
    """,
)
@click.argument("shell", type=click.Choice(SHELLS))
def command(shell: str) -> None:
    """Print the script with which a shell completes commands, options and values."""
    from click.shell_completion import get_completion_class

    from trackmetrics.cli._main import trackmetrics

    found = get_completion_class(shell)
    assert found is not None
    script = found(trackmetrics, {}, "trackmetrics", "_TRACKMETRICS_COMPLETE").source()
    click.echo(script)
