import typing

ffi: typing.Any
lib: typing.Any
