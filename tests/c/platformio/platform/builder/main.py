"""Builds a project with the compiler of the board, or of this machine."""

from SCons.Script import Default, DefaultEnvironment

env = DefaultEnvironment()
env.Replace(PROGNAME="firmware")
if "BOARD" in env:
    env.Replace(**{tool: "arm-none-eabi-" + tool.lower() for tool in ("AR", "AS", "RANLIB")})
    env.Replace(CC="arm-none-eabi-gcc", CXX="arm-none-eabi-g++", ARFLAGS=["rc"], PROGSUFFIX=".elf")
    flags = [f"-mcpu={env.BoardConfig().get('build.cpu')}", "-mthumb", *env.BoardConfig().get("build.flags")]
    env.Append(CCFLAGS=flags, LINKFLAGS=[*flags, "--specs=nosys.specs"])
Default(env.BuildProgram())
