!> Parameters of a soil law as plain data that describe themselves: the keyword, its fields, the properties that other
!> modules need before the law exists, the creation of the model, and the division of the strength by a factor. For a
!> law that does not define which parameters are its strength, the user names them (qsmpm_strength_factor).
!>
!> A law extends `law_parameters_type` in the module of its model and is listed in qsmpm_law_factory; the deck generates
!> its keyword, help and echo from this. The default of a field is the value of the component; values outside the range
!> of a field are not set.
module qsmpm_law_parameters
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type, error_deck, fail
  use qsmpm_principal_model, only: principal_model_type
  use qsmpm_soil_model, only: soil_model_type
  use qsmpm_strength_factor, only: strength_factor_type, strength_constant_type
  implicit none
  private

  public :: law_parameters_type, law_parameters_slot_type, law_description_type, field_visitor_type

  !> Visits the fields of a law: to describe, read or write them.
  type, abstract :: field_visitor_type
  contains
    procedure(number_interface), deferred :: law_number
    procedure(choice_interface), deferred :: law_choice
    procedure(data_interface), deferred :: law_data
  end type field_visitor_type

  !> Properties of a law and of its kind of material, without its parameters.
  type :: law_description_type
    !> Keyword, sentences of help, lines of an example separated by bars.
    character(len=:), allocatable :: keyword, sentence, example
    !> Elasticity is linear, so that the stress rate of the paper may be used.
    logical :: linear_elasticity = .false.
    !> Poisson's ratio, if known; near 1/2 a grid locks.
    real(wp) :: poisson = 0.0_wp
    !> The stress is limited by a strength at which the stiffness vanishes.
    logical :: has_strength = .false.
    !> The strength may decrease.
    logical :: may_soften = .false.
    !> Plastic flow is normal to the yield surface.
    logical :: associated_flow = .true.
    !> The volume change at failure is proportional to the shear strain at all strains; and is zero.
    logical :: failure_ties_volume = .false., failure_keeps_volume = .false.
    !> Dilatancy angle of failure in degrees.
    real(wp) :: dilatancy_angle = 0.0_wp
    !> Friction angle in degrees and cohesion of the strength in compression; negative where not known.
    real(wp) :: friction_angle = -1.0_wp, cohesion = -1.0_wp
    !> The stiffness depends on the stress above this mean pressure, so that points should start above it; 0: none.
    real(wp) :: smallest_pressure = 0.0_wp
    !> The model is in total stress: separate pore water would count twice.
    logical :: total_stress = .false.
    !> The state contains a tensor, which images of a reduced scene do not rotate.
    logical :: keeps_tensor = .false.
    !> The model creeps in the time of the phases.
    logical :: flows_in_time = .false.
    !> Axis used as the vertical by the law, 0 for none.
    integer :: vertical = 0
  end type law_description_type

  !> Parameters of a law.
  type, abstract :: law_parameters_type
  contains
    procedure(describe_interface), deferred :: describe
    procedure(fields_interface), deferred :: fields
    !> One of these makes the model: in principal values if it has no directions of its own, otherwise in tensors.
    procedure :: make_model => no_model
    procedure :: make_soil_model => no_soil_model
    !> Reduces the strength, as defined by the law or for the constants that the user names.
    procedure :: lower => refuse_to_lower
    procedure :: lower_named => refuse_constants
  end type law_parameters_type

  !> Element of a list of laws.
  type :: law_parameters_slot_type
    class(law_parameters_type), allocatable :: parameters
  end type law_parameters_slot_type

  abstract interface
    !> Visits a number: a parameter of the keyword line or, after `data_interface`, a column of the data line.
    subroutine number_interface(self, name, value, sentence, range, required)
      import :: field_visitor_type, wp
      class(field_visitor_type), intent(inout) :: self
      character(len=*), intent(in) :: name, sentence
      real(wp), intent(inout) :: value
      !> Interval notation: '(0, inf)'.
      character(len=*), intent(in) :: range
      !> False if the column may be omitted.
      logical, intent(in), optional :: required
    end subroutine number_interface

    !> Visits a choice between words, stored as the number of the word from 1.
    subroutine choice_interface(self, name, value, words, sentence)
      import :: field_visitor_type
      class(field_visitor_type), intent(inout) :: self
      character(len=*), intent(in) :: name, sentence
      integer, intent(inout) :: value
      !> Words separated by bars.
      character(len=*), intent(in) :: words
    end subroutine choice_interface

    !> Starts the data line.
    subroutine data_interface(self, name)
      import :: field_visitor_type
      class(field_visitor_type), intent(inout) :: self
      character(len=*), intent(in) :: name
    end subroutine data_interface

    pure type(law_description_type) function describe_interface(self) result(law)
      import :: law_parameters_type, law_description_type
      class(law_parameters_type), intent(in) :: self
    end function describe_interface

    !> Passes the fields to a visitor.
    subroutine fields_interface(self, visitor)
      import :: law_parameters_type, field_visitor_type
      class(law_parameters_type), intent(inout) :: self
      class(field_visitor_type), intent(inout) :: visitor
    end subroutine fields_interface
  end interface

contains

  !> Makes no model in principal values.
  subroutine no_model(self, model, error)
    class(law_parameters_type), intent(in) :: self
    class(principal_model_type), allocatable, intent(out) :: model
    !> Reason for which there is none: a parameter is out of its range.
    type(error_type), allocatable, intent(out) :: error

    associate (unused => self)
    end associate
  end subroutine no_model

  !> Makes no model in tensors.
  subroutine no_soil_model(self, model, error)
    class(law_parameters_type), intent(in) :: self
    class(soil_model_type), allocatable, intent(out) :: model
    !> As in `make_model`.
    type(error_type), allocatable, intent(out) :: error

    associate (unused => self)
    end associate
  end subroutine no_soil_model

  !> Rejects the reduction of a strength that the law does not define.
  subroutine refuse_to_lower(self, by, error)
    class(law_parameters_type), intent(inout) :: self
    type(strength_factor_type), intent(in) :: by
    !> error_deck: names the keyword.
    type(error_type), allocatable, intent(out) :: error
    type(law_description_type) :: law

    law = self%describe()
    call fail(error, error_deck, '*'//law%keyword//' does not say which of its parameters are a strength that a '// &
      'factor may divide: name them by *STRENGTH CONSTANTS')
  end subroutine refuse_to_lower

  !> Rejects constants that the user names.
  subroutine refuse_constants(self, named, by, error)
    class(law_parameters_type), intent(inout) :: self
    type(strength_constant_type), intent(in) :: named(:)
    type(strength_factor_type), intent(in) :: by
    !> error_deck: names the keyword.
    type(error_type), allocatable, intent(out) :: error
    type(law_description_type) :: law

    law = self%describe()
    call fail(error, error_deck, '*'//law%keyword//' takes no *STRENGTH CONSTANTS')
  end subroutine refuse_constants
end module qsmpm_law_parameters
