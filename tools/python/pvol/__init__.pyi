from os import PathLike
from typing import Any, Callable, Literal, Mapping, Sequence, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str

_Path = str | PathLike[str]
_Colour = float | Sequence[float]
_Counts = dict[str, NDArray[np.uint64]]
_Tracker = Literal[
    "delta-global", "delta", "decomposition", "weighted-delta", "weighted-decomposition", "regular"
]
_Estimator = Literal["auto", "ratio", "analog", "residual", "residual-ratio", "exact", "regular"]
_Interpolation = Literal["nearest", "trilinear", "tricubic", "procedural"]
_Scene = _Path | Mapping[str, Any] | Volume | Sequence[Volume]

class Error(ValueError): ...

class Volume:
    def __init__(
        self,
        array: NDArray[Any],
        voxel_size: float | Sequence[float] | None = None,
        index_to_world: ArrayLike | None = None,
        name: str = "array",
        *,
        extinction: float = 1,
        albedo: _Colour = 0.999,
        g: float = 0.5,
        emission: _Colour = 0,
        interpolation: _Interpolation = "trilinear",
        depth: int | None = None,
        micro_bounds: str = "auto",
        homogenise: float | None = None,
        majorant_scale: float = 1,
        **medium: Any,
    ) -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def support(self) -> NDArray[np.int64]: ...
    @property
    def shape(self) -> tuple[int, int, int]: ...
    @property
    def world_box(self) -> NDArray[np.float64]: ...
    @property
    def index_to_world(self) -> NDArray[np.float64]: ...
    @property
    def extinction(self) -> float: ...
    @property
    def albedo(self) -> NDArray[np.float64]: ...
    @property
    def interpolation(self) -> str: ...
    @property
    def depth(self) -> int: ...
    @property
    def levels(self) -> int: ...
    @property
    def bytes(self) -> dict[str, int]: ...
    @property
    def shell(self) -> Shell | None: ...
    def with_medium(self, **medium: Any) -> Volume: ...
    def with_options(
        self,
        *,
        interpolation: _Interpolation = ...,
        depth: int | None = ...,
        micro_bounds: str | None = ...,
        homogenise: float | None = ...,
        majorant_scale: float | None = ...,
    ) -> Volume: ...
    def with_shell(self, shell: Shell | None) -> Volume: ...
    def density(self, points: ArrayLike) -> NDArray[np.float32]: ...
    def extinction_at(self, points: ArrayLike) -> NDArray[np.float32]: ...
    @overload
    def flights(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        t_max: ArrayLike = ...,
        seed: int = 0,
        tracker: _Tracker = "decomposition",
        counts: Literal[False] = False,
        kernel: Literal["auto", "scalar"] = "auto",
    ) -> NDArray[np.float64]: ...
    @overload
    def flights(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        t_max: ArrayLike = ...,
        seed: int = 0,
        tracker: _Tracker = "decomposition",
        *,
        counts: Literal[True],
        kernel: Literal["auto", "scalar"] = "auto",
    ) -> tuple[NDArray[np.float64], _Counts]: ...
    @overload
    def transmittance(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        t_max: ArrayLike = ...,
        seed: int = 0,
        estimator: _Estimator = "ratio",
        counts: Literal[False] = False,
        kernel: Literal["auto", "scalar"] = "auto",
    ) -> NDArray[np.float64]: ...
    @overload
    def transmittance(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        t_max: ArrayLike = ...,
        seed: int = 0,
        estimator: _Estimator = "ratio",
        *,
        counts: Literal[True],
        kernel: Literal["auto", "scalar"] = "auto",
    ) -> tuple[NDArray[np.float64], _Counts]: ...
    @overload
    def optical_depth(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        t_max: ArrayLike = ...,
        counts: Literal[False] = False,
    ) -> NDArray[np.float64]: ...
    @overload
    def optical_depth(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        t_max: ArrayLike = ...,
        *,
        counts: Literal[True],
    ) -> tuple[NDArray[np.float64], _Counts]: ...
    def bounds(self, level: int | None = None) -> NDArray[np.void]: ...
    def segments(
        self, origin: ArrayLike, direction: ArrayLike, t_max: float = ...
    ) -> NDArray[np.void]: ...

class Shell:
    @property
    def kind(self) -> Literal["hard", "soft"]: ...
    @property
    def quadrics(self) -> NDArray[np.float64]: ...
    @property
    def strengths(self) -> NDArray[np.float64]: ...
    @property
    def world_to_frame(self) -> NDArray[np.float64]: ...
    @property
    def certificate(self) -> dict[str, float]: ...
    @property
    def tightness(self) -> dict[str, float]: ...
    def contains(self, points: ArrayLike) -> NDArray[np.bool_]: ...
    def intersect(
        self, origins: ArrayLike, directions: ArrayLike, t_max: ArrayLike = ...
    ) -> NDArray[np.void]: ...
    def mesh(self, resolution: int = 128) -> tuple[NDArray[np.float64], NDArray[np.uint32]]: ...

class Picture:
    @property
    def rgb(self) -> NDArray[np.float32]: ...
    @property
    def alpha(self) -> NDArray[np.float32]: ...
    @property
    def error(self) -> NDArray[np.float32]: ...
    @property
    def samples(self) -> NDArray[np.float32]: ...
    @property
    def layers(self) -> list[str]: ...
    @property
    def counts(self) -> dict[str, int]: ...
    @property
    def plan(self) -> str: ...
    @property
    def attributes(self) -> dict[str, str]: ...
    @property
    def color_space(self) -> str: ...
    @property
    def noise(self) -> float | None: ...
    def aov(self, name: str) -> NDArray[np.float32]: ...
    def save(
        self,
        path: _Path,
        exposure: float = 0,
        tone_map: str = "srgb",
    ) -> None: ...

class Live:
    def __init__(self, scene: _Scene, **settings: Any) -> None: ...
    def change(self, scene: _Scene, **settings: Any) -> None: ...
    def picture(self) -> Picture | None: ...
    @property
    def version(self) -> int: ...
    def wait(self, version: int, seconds: float) -> bool: ...
    @property
    def finished(self) -> bool: ...
    @property
    def error(self) -> str | None: ...
    def close(self) -> None: ...
    def __enter__(self) -> Live: ...
    def __exit__(self, *exception: object) -> None: ...

def load(
    path: _Path, grid: str | None = None, *, interpolation: _Interpolation = ..., **settings: Any
) -> Volume: ...
def fit_shell(
    volume: Volume,
    kind: Literal["hard", "soft"] = "hard",
    perturbations: int | None = None,
    effort: int = 1,
) -> Shell: ...
def render(
    scene: _Scene,
    *,
    on_pass: Callable[[Picture, float | None], object] | None = None,
    count: bool = False,
    force: bool = False,
    denoise: bool = False,
    **settings: Any,
) -> Picture: ...
def read_picture(path: _Path) -> Picture: ...
def tone_maps() -> list[str]: ...
def compare(a: Picture | _Path, b: Picture | _Path) -> dict[str, Any]: ...
def trade(
    scene: _Scene,
    variants: Sequence[Mapping[str, Any]] | None = None,
    budget: float = 60,
    most_samples: int = 0,
    **settings: Any,
) -> list[dict[str, Any]]: ...
