!> What the user says of a soil law, as plain data that describes itself: the card of the deck, the fields that belong
!> to
!> it, what other rooms ask of such a law before there is one, the model that is made of it, and how its strength is
!> divided by a factor; a law that does not say so wants the constants named that are (qsmpm_strength_factor).
!>
!> A law extends `law_parameters_type` beside its model and is entered in qsmpm_law_factory; the deck makes its card,
!> help and echo of this. The default of a field is the value that the component has; a value outside its range is not
!> set.
module qsmpm_law_parameters
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type, error_deck, fail
  use qsmpm_principal_model, only: principal_model_type
  use qsmpm_soil_model, only: soil_model_type
  use qsmpm_strength_factor, only: strength_factor_type, strength_constant_type
  implicit none
  private

  public :: law_parameters_type, law_parameters_slot_type, law_description_type, field_visitor_type

  !> Goes over the fields of a law: to describe, read or write them.
  type, abstract :: field_visitor_type
  contains
    procedure(number_interface), deferred :: law_number
    procedure(choice_interface), deferred :: law_choice
    procedure(data_interface), deferred :: law_data
  end type field_visitor_type

  !> What is said of a law without its parameters, and of its kind of material.
  type :: law_description_type
    !> Keyword of the card, sentences of help, lines of an example with bars between them.
    character(len=:), allocatable :: keyword, sentence, example
    !> Elasticity is linear, so that the paper's rule for the stress rate may be taken.
    logical :: linear_elasticity = .false.
    !> Poisson's ratio, where it is known; near 1/2 a grid locks.
    real(wp) :: poisson = 0.0_wp
    !> The stress is bounded by a strength that ends all stiffness.
    logical :: has_strength = .false.
    !> The strength may fall.
    logical :: may_soften = .false.
    !> Plastic flow is normal to the yield surface.
    logical :: associated_flow = .true.
    !> The volume change of failure is tied to its shear strain for good; and is none.
    logical :: failure_ties_volume = .false., failure_keeps_volume = .false.
    !> Dilatancy angle of failure in degrees.
    real(wp) :: dilatancy_angle = 0.0_wp
    !> Friction angle in degrees and cohesion of its strength in compression; negative where they are not known.
    real(wp) :: friction_angle = -1.0_wp, cohesion = -1.0_wp
    !> Stiffness comes of the stress above this mean pressure, so that a point should start with more; 0: it does not.
    real(wp) :: smallest_pressure = 0.0_wp
    !> The stress is total: pore water of its own would count twice.
    logical :: total_stress = .false.
    !> Its state holds a tensor, which images of a reduced scene do not turn.
    logical :: keeps_tensor = .false.
    !> It flows in the time of the phases.
    logical :: flows_in_time = .false.
    !> Axis that the law takes for the vertical, 0 for none.
    integer :: vertical = 0
  end type law_description_type

  !> Parameters of a law.
  type, abstract :: law_parameters_type
  contains
    procedure(describe_interface), deferred :: describe
    procedure(fields_interface), deferred :: fields
    !> One of these makes the model: in principal values where it has no directions of its own, else of tensors.
    procedure :: make_model => no_model
    procedure :: make_soil_model => no_soil_model
    !> Lower the strength, as the law knows it or the constants that the user names.
    procedure :: lower => refuse_to_lower
    procedure :: lower_named => refuse_constants
  end type law_parameters_type

  !> One of a list.
  type :: law_parameters_slot_type
    class(law_parameters_type), allocatable :: parameters
  end type law_parameters_slot_type

  abstract interface
    !> A number: a parameter of the card or, after `law_data`, a column of its data line.
    subroutine number_interface(self, name, value, sentence, range, required)
      import :: field_visitor_type, wp
      class(field_visitor_type), intent(inout) :: self
      character(len=*), intent(in) :: name, sentence
      real(wp), intent(inout) :: value
      !> As in mathematics: '(0, inf)'.
      character(len=*), intent(in) :: range
      !> A column may be left out where this is false.
      logical, intent(in), optional :: required
    end subroutine number_interface

    !> One of several words, kept as its number from 1.
    subroutine choice_interface(self, name, value, words, sentence)
      import :: field_visitor_type
      class(field_visitor_type), intent(inout) :: self
      character(len=*), intent(in) :: name, sentence
      integer, intent(inout) :: value
      !> With bars between them.
      character(len=*), intent(in) :: words
    end subroutine choice_interface

    !> The data line begins.
    subroutine data_interface(self, name)
      import :: field_visitor_type
      class(field_visitor_type), intent(inout) :: self
      character(len=*), intent(in) :: name
    end subroutine data_interface

    pure type(law_description_type) function describe_interface(self) result(law)
      import :: law_parameters_type, law_description_type
      class(law_parameters_type), intent(in) :: self
    end function describe_interface

    !> Take a visitor over the fields.
    subroutine fields_interface(self, visitor)
      import :: law_parameters_type, field_visitor_type
      class(law_parameters_type), intent(inout) :: self
      class(field_visitor_type), intent(inout) :: visitor
    end subroutine fields_interface
  end interface

contains

  !> There is none in principal values.
  subroutine no_model(self, model, error)
    class(law_parameters_type), intent(in) :: self
    class(principal_model_type), allocatable, intent(out) :: model
    !> Why there is none: a parameter is out of its range.
    type(error_type), allocatable, intent(out) :: error

    associate (unused => self)
    end associate
  end subroutine no_model

  !> There is none of tensors.
  subroutine no_soil_model(self, model, error)
    class(law_parameters_type), intent(in) :: self
    class(soil_model_type), allocatable, intent(out) :: model
    !> As of `make_model`.
    type(error_type), allocatable, intent(out) :: error

    associate (unused => self)
    end associate
  end subroutine no_soil_model

  !> Refuse to lower a strength that the law does not name.
  subroutine refuse_to_lower(self, by, error)
    class(law_parameters_type), intent(inout) :: self
    type(strength_factor_type), intent(in) :: by
    !> error_deck: names the card.
    type(error_type), allocatable, intent(out) :: error
    type(law_description_type) :: law

    law = self%describe()
    call fail(error, error_deck, '*'//law%keyword//' does not say which of its parameters are a strength that a '// &
      'factor may divide: name them by *STRENGTH CONSTANTS')
  end subroutine refuse_to_lower

  !> Refuse constants that the user names.
  subroutine refuse_constants(self, named, by, error)
    class(law_parameters_type), intent(inout) :: self
    type(strength_constant_type), intent(in) :: named(:)
    type(strength_factor_type), intent(in) :: by
    !> error_deck: names the card.
    type(error_type), allocatable, intent(out) :: error
    type(law_description_type) :: law

    law = self%describe()
    call fail(error, error_deck, '*'//law%keyword//' takes no *STRENGTH CONSTANTS')
  end subroutine refuse_constants
end module qsmpm_law_parameters
