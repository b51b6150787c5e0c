!> A law around another one, which it changes stresses, states or steps of: what it does not say itself is as the law
!> inside says.
module qsmpm_outer_law
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: law_type
  implicit none
  private

  public :: outer_law_type

  !> The law; what others ask of it is set by `describe_as`.
  type, abstract, extends(law_type) :: outer_law_type
    class(law_type), allocatable :: law
  contains
    procedure :: describe_as
    procedure :: start_at
    procedure :: blend
    procedure :: fit_count
    procedure :: to_fields
    procedure :: from_fields
  end type outer_law_type

contains

  !> Be described as the law inside is.
  pure subroutine describe_as(self, law)
    class(outer_law_type), intent(inout) :: self
    class(law_type), intent(in) :: law

    self%law_traits_type = law%law_traits_type
  end subroutine describe_as

  !> The share of the elastic tangent is that of the law inside.
  subroutine blend(self, share)
    class(outer_law_type), intent(inout) :: self
    real(wp), intent(in) :: share

    self%elastic_blend = share
    call self%law%blend(share)
  end subroutine blend

  !> State of a point.
  subroutine start_at(self, stress, place, state)
    class(outer_law_type), intent(in) :: self
    real(wp), intent(in) :: stress(:), place(3)
    real(wp), intent(out) :: state(:)

    call self%law%start_at(stress, place, state)
  end subroutine start_at

  !> Number of fields that are averaged.
  pure integer function fit_count(self)
    class(outer_law_type), intent(in) :: self

    fit_count = self%law%fit_count()
  end function fit_count

  !> Fields of stress and state.
  pure subroutine to_fields(self, stress, state, fields)
    class(outer_law_type), intent(in) :: self
    real(wp), intent(in) :: stress(:), state(:)
    real(wp), intent(out) :: fields(:)

    call self%law%to_fields(stress, state, fields)
  end subroutine to_fields

  !> And back.
  pure subroutine from_fields(self, fields, volume_ratio, stress, state)
    class(outer_law_type), intent(in) :: self
    real(wp), intent(in) :: fields(:), volume_ratio
    real(wp), intent(out) :: stress(:), state(:)

    call self%law%from_fields(fields, volume_ratio, stress, state)
  end subroutine from_fields
end module qsmpm_outer_law
