"""What acts in a joint of one freedom."""

from pydantic import Field

from .fields import NotNegative, Number, Part, in_si


class AngularSpring(Part):
    """stiffness : N m/rad. rest (rad) or rest_deg : the angle at which it is slack."""

    exclusive = (("rest", "rest_deg"),)

    stiffness: NotNegative = Field(description="stiffness in N m/rad")
    rest: Number | None = None
    rest_deg: Number | None = None

    def rest_value(self):
        """rad."""
        return in_si(self, "rest")


class LinearSpring(Part):
    """stiffness : N/m. rest : the position at which it is slack, m."""

    stiffness: NotNegative = Field(description="stiffness in N/m")
    rest: Number = 0.0

    def rest_value(self):
        """m."""
        return self.rest
