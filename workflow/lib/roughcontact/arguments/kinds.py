"""What is fixed for a kind of problem, whatever its map: its load, its border, and the settings it excludes.

Rooms of every level read these facts by the word `boundary`, which settings, maps and results carry; nobody
else compares that word. What a kind does is in `roughcontact.evaluation.kinds`.
"""

from collections import defaultdict
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from roughcontact.arguments.choices import Boundary
from roughcontact.arguments.rows import rows_beside
from roughcontact.errors import SettingsError

Sections = Mapping[str, Mapping[str, Any]]


# kind -> "layers" of bodies, "faces" of a pair, "" of all -> setting, or argument -> why it does not apply
_EXCLUDED: dict[str, dict[str, dict[str, str]]] = defaultdict(lambda: defaultdict(dict))
for _kind, _property, _settings, _reason in rows_beside(__file__, "excluded.tsv"):
    _EXCLUDED[_kind][_property] |= dict.fromkeys(_settings.split(", "), _reason)


@dataclass(frozen=True)
class KindFacts:
    """The facts of a kind of problem, by default those of a periodic map.

    Attributes
    ----------
    name : str
        of the kind, in words.
    boundary : {"periodic", "free"}
        the word for it in settings and results.
    load, load_in_words, load_unit, load_symbol : str
        argument of `solve_contact` that is its load, and coordinate of its results; how it is spoken of.
    load_over_pressure : callable
        area of the map (m2) -> load over mean pressure.
    border : int
        lines without contact around the map: 1 where the body ends there, 0 where the map goes on.
    recorded : collection of str
        rules of the solver that its results carry.
    has_flow, has_theories : bool
        whether a fluid flows through its gap, and theories of endless surfaces hold.
    noun : str
        what is solved, where that is no window of a map.
    own_numbers : tuple of str
        numbers of each load that only this kind has; by the first of them its results are told.
    scaled_columns : collection of str
        numbers of the solution that are relative to the roughness of its map.
    form_is_meant : bool
        whether the form of the map is one of the problem, no remainder of levelling.
    may_leave_map : bool
        whether under a larger load its contact reaches the border of the map.
    flat_map_is_uniform : bool
        whether the pressure on a flat map is the same everywhere.
    power_of_largest_pressure : float
        of the load, with which the largest pressure rises at first.
    area_reference, surroundings : str
        what the relative contact area is a share of, and what the half-space is beyond it, in words.
    sentence : str
        that of the report on the size of its contact (`report/templates/sentences.txt`).
    admitted : collection of str
        the settings of an excluded section that apply.
    own_settings : mapping
        stage of the workflow -> settings on which it depends beside its own sections.
    """

    name: str = "periodic map"
    boundary: Boundary = "periodic"
    load: str = "mean_pressure"
    load_in_words: str = "mean pressure"
    load_unit: str = "Pa"
    load_symbol: str = "p̄"
    load_over_pressure: Callable[[float], float] = field(default=lambda area: 1.0)
    border: int = 0
    recorded: Collection[str] = ("zero_frequency",)
    has_flow: bool = True
    has_theories: bool = True
    noun: str = ""
    own_numbers: tuple[str, ...] = ()
    scaled_columns: Collection[str] = ("relative_pressure",)
    form_is_meant: bool = False
    may_leave_map: bool = False
    flat_map_is_uniform: bool = True
    power_of_largest_pressure: float = 0.2
    area_reference: str = "nominal area"
    surroundings: str = "of one period"
    sentence: str = ""
    admitted: Collection[str] = ()
    own_settings: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    @property
    def excluded(self) -> Mapping[str, Mapping[str, str]]:
        """Property of bodies or map, "" of all -> setting, section or argument -> why it does not apply."""
        return _EXCLUDED[self.name]

    def is_stated(self, form: Mapping[str, Any], contact: Mapping[str, Any]) -> bool:
        """Return whether the sections `form` and `contact` of settings, checked or not, state this kind."""
        return contact.get("boundary") == self.boundary

    def adds_form(self, attrs: Mapping[str, Any]) -> bool:
        """Return whether a form was added to the map with these attributes."""
        return False

    def arguments(self, pressure: float, area: float) -> dict[str, Any]:
        """Return the arguments of `solve_contact` for a mean pressure (Pa) on the area of a map (m2)."""
        return {"boundary": self.boundary, self.load: pressure * self.load_over_pressure(area)}

    def coordinates(self, load: float, area: float) -> dict[str, float]:
        """Return a load on the area of a map (m2) as coordinates of its result, the mean pressure first."""
        return {"mean_pressure": load / self.load_over_pressure(area), self.load: load}

    def text_of_load(self, load: float) -> str:
        """Return a load as messages name it.

        Examples
        --------
        >>> FINITE_BODY.text_of_load(2.0)
        'force 2 N'
        """
        return f"{self.load_in_words} {load:.4g} {self.load_unit}"

    def reason_against(self, setting: str, properties: Collection[str] = ()) -> str:
        """Return why a setting, or a value of it, does not apply, and the way out; nothing where it does.

        Examples
        --------
        >>> FINITE_BODY.reason_against("contact.zero_frequency")
        'the approach of a finite body is absolute; leave it out'
        >>> FINITE_BODY.reason_against("window.min_share = 0.1"), PERIODIC_MAP.reason_against("window.width")
        ('', '')
        """
        rules = {key: why for property_ in ("", *properties) for key, why in self.excluded[property_].items()}
        name = setting.partition(" = ")[0]
        section = "" if name in self.admitted else name.partition(".")[0]
        return next((rules[key] for key in (setting, name, section) if key in rules), "")

    def check_arguments(self, keys: Collection[str], properties: Collection[str] = ()) -> None:
        """Raise SettingsError for the first stated argument of `solve_contact` that does not apply."""
        for name in keys:
            reason = self.reason_against(name) or self.reason_against(f"contact.{name}", properties)
            if reason:
                raise SettingsError(f"{name}, boundary {self.boundary!r}: {reason}", keys=(name,))

    def mistakes_in_loads(self, keys: Collection[str]) -> Iterator[tuple[str, str]]:
        """Yield the name and the mistake of loads among the `keys` of the section `contact`."""
        for missing, present in (("area", "force"), ("force", "area")):
            if present in keys and missing not in keys:
                text = f": missing, though {present} is given; mean pressure is force by area"
                yield f"contact.{missing}", text

    def mistakes(
        self, settings: Sections, defaults: Sections, properties: Collection[str] = ()
    ) -> Iterator[tuple[str, str]]:
        """Yield name and mistake of each setting that was changed although it does not apply."""
        usual = dict(named_settings(defaults))
        for name, value in named_settings(settings):
            reason = self.reason_against(f"{name} = {value!r}", properties)
            if reason and value != usual.get(name):
                yield name, f" = {_as_stated(value)!r}: {reason}"


@dataclass(frozen=True)
class FiniteBodyFacts(KindFacts):
    """The facts of a body of finite size, which has no neighbours and stands under a force."""

    def adds_form(self, attrs: Mapping[str, Any]) -> bool:
        """Return whether the map is the roughness on a ball or an ellipsoid."""
        return "form_radius_x" in attrs

    def mistakes_in_loads(self, keys: Collection[str]) -> Iterator[tuple[str, str]]:
        """Yield that the force is missing."""
        pressures = [key for key in ("mean_pressure", "relative_pressure") if key in keys]
        if self.load not in keys:
            instead = f" instead of the {pressures[0]}" if pressures else ""
            yield "contact.force", f": missing, though boundary is free; give the force in N{instead}"


@dataclass(frozen=True)
class LocalScaleFacts(KindFacts):
    """The facts of a map smaller than the contact, each place of which is under a pressure of Hertz."""

    def is_stated(self, form: Mapping[str, Any], contact: Mapping[str, Any]) -> bool:
        """Return whether the section `form` has a form that is wider than the map."""
        return bool(form.get("local_scale"))

    def mistakes_in_loads(self, keys: Collection[str]) -> Iterator[tuple[str, str]]:
        """Yield nothing: the force on the form is the load."""
        yield from ()


PERIODIC_MAP = KindFacts()
LOCAL_SCALE = LocalScaleFacts(name="local scale", own_settings={"contact": ("form",)})
FINITE_BODY = FiniteBodyFacts(
    name="finite body",
    boundary="free",
    load="force",
    load_in_words="force",
    load_unit="N",
    load_symbol="F",
    load_over_pressure=lambda area: area,
    border=1,
    recorded=("boundary",),
    has_flow=False,
    has_theories=False,
    noun="a body of finite size",
    own_numbers=("contact_radius", "force"),
    scaled_columns=(),  # the gradient of the map is that of the form
    form_is_meant=True,
    may_leave_map=True,
    flat_map_is_uniform=False,
    power_of_largest_pressure=1 / 3,  # of a ball (Hertz)
    area_reference="area of the map",
    surroundings="without neighbours",
    sentence="finite_body",
    admitted=("window.min_share",),
    own_settings={"window": ("form", "contact.boundary")},
)


# the first that settings state is theirs, without any a periodic map
KIND_FACTS: tuple[KindFacts, ...] = (LOCAL_SCALE, FINITE_BODY, PERIODIC_MAP)


# settings that say which kind a problem is: its load, its border and its form
SETTINGS_OF_KIND = (
    *dict.fromkeys(f"contact.{facts.load}" for facts in KIND_FACTS),
    "contact.boundary",
    "form.radius",
)


def facts_of(attrs: Mapping[str, Any]) -> KindFacts:
    """Return the facts by the word `boundary` in a section `contact`, or the attributes of a map or result.

    Examples
    --------
    >>> facts_of({}).load, facts_of({"boundary": "free"}).load
    ('mean_pressure', 'force')
    """
    return facts_of_settings({"contact": attrs})


def settings_on_form(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return what follows from settings, by their dotted names, of a map that is the roughness of a form."""
    return {"contact.boundary": FINITE_BODY.boundary} if settings.get("form.radius") else {}


def number_of_faces(attrs: Mapping[str, Any]) -> int:
    """Return how many rough faces are in the heights of a map, by its attributes: one, or both of a pair.

    Examples
    --------
    >>> number_of_faces({}), number_of_faces({"counter_face": "lower.x3p"})
    (1, 2)
    """
    return 1 + ("counter_face" in attrs)


def properties_of_map(attrs: Mapping[str, Any]) -> tuple[str, ...]:
    """Return what a map, by its attributes, has that may exclude settings: the "faces" of a pair, or nothing.

    Examples
    --------
    >>> properties_of_map({}), properties_of_map({"counter_face": "lower.x3p"})
    ((), ('faces',))
    """
    return ("faces",) if number_of_faces(attrs) > 1 else ()


def facts_of_settings(settings: Mapping[str, Any]) -> KindFacts:
    """Return the facts of the kind that the sections of settings, checked or not, describe.

    Examples
    --------
    >>> facts_of_settings({"form": {"local_scale": True}}).name
    'local scale'
    """
    form, contact = (
        section if isinstance(section := settings.get(name), Mapping) else {} for name in ("form", "contact")
    )
    return next((facts for facts in KIND_FACTS if facts.is_stated(form, contact)), PERIODIC_MAP)


def named_settings(settings: Mapping[str, Any], where: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the full name and the value of each setting, of groups within a section and what is in them.

    Examples
    --------
    >>> dict(named_settings({"statistics": {"seal": {"width": 1e-3}}}))
    {'statistics.seal': {'width': 0.001}, 'statistics.seal.width': 0.001}
    """
    for key, value in settings.items():
        if where or not isinstance(value, Mapping):
            yield f"{where}{key}", value
        if isinstance(value, Mapping):
            yield from named_settings(value, f"{where}{key}.")


def _as_stated(value: Any) -> Any:
    """Return a value as settings state it: of a group what is given, and true for no load in particular."""
    if isinstance(value, Mapping):
        return {key: entry for key, entry in value.items() if entry is not None}
    return True if value == [] else value
