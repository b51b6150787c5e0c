!> What an isotropic soil model says of a point in principal values: trial elastic strain to stress, history
!> and derivative. Directions and finite strain are those of qsmpm_isotropic_law, which serves every model of
!> this form in both kinematics.
!>
!> The stress is the Cauchy stress, tension positive, principal values in any order; the strain is the elastic
!> strain that carries it. Moduli may depend on the stress: `modulus` is what the model keeps of them for the
!> length of a step, so that the map from the trial strain to the stress is isotropic.
module qsmpm_isotropic_model
  use qsmpm_kinds, only: wp
  use qsmpm_tensor, only: identity
  use qsmpm_text, only: string_type
  implicit none
  private

  public :: isotropic_model_type, answer_type, elastic_map

  !> Most history variables of a model.
  integer, parameter, public :: most_history = 4

  !> Answer to a trial strain.
  type :: answer_type
    !> False where no stress was found.
    logical :: found = .true.
    logical :: yields = .false.
    !> Principal stresses (3).
    real(wp) :: stress(3) = 0.0_wp
    !> d stress / d trial strain (3,3).
    real(wp) :: derivative(3, 3) = 0.0_wp
    !> History at the end of the step; the first history_count are used.
    real(wp) :: history(most_history) = 0.0_wp
  end type answer_type

  !> A model.
  type, abstract :: isotropic_model_type
    !> History variables of a point.
    integer :: history_count = 0
    !> Their names in results.
    type(string_type), allocatable :: history_names(:)
    !> Young's modulus and shear modulus at a usual stress, for scaling.
    real(wp) :: young = 0.0_wp
    real(wp) :: shear = 0.0_wp
    !> What is said of a point without an answer.
    character(len=:), allocatable :: complaint
  contains
    procedure(start_interface), deferred :: start_history
    procedure(clamp_interface), deferred :: clamp_history
    procedure(modulus_interface), deferred :: step_modulus
    procedure(strain_interface), deferred :: elastic_strain
    procedure(elastic_interface), deferred :: elastic_answer
    procedure(respond_interface), deferred :: respond
  end type isotropic_model_type

  abstract interface
    !> History that belongs to a given stress.
    pure subroutine start_interface(self, stress, history)
      import :: isotropic_model_type, wp
      class(isotropic_model_type), intent(in) :: self
      !> Principal stresses (3).
      real(wp), intent(in) :: stress(3)
      !> (history_count)
      real(wp), intent(out) :: history(:)
    end subroutine start_interface

    !> Bring a history that was averaged over points back into its range.
    pure subroutine clamp_interface(self, history)
      import :: isotropic_model_type, wp
      class(isotropic_model_type), intent(in) :: self
      !> (history_count)
      real(wp), intent(inout) :: history(:)
    end subroutine clamp_interface

    !> The modulus of a step that starts from a stress.
    pure real(wp) function modulus_interface(self, stress)
      import :: isotropic_model_type, wp
      class(isotropic_model_type), intent(in) :: self
      !> Principal stresses (3).
      real(wp), intent(in) :: stress(3)
    end function modulus_interface

    !> Elastic strain of a stress.
    pure function strain_interface(self, modulus, stress) result(strain)
      import :: isotropic_model_type, wp
      class(isotropic_model_type), intent(in) :: self
      !> Modulus of the step.
      real(wp), intent(in) :: modulus
      !> Principal stresses (3).
      real(wp), intent(in) :: stress(3)
      real(wp) :: strain(3)
    end function strain_interface

    !> The answer without strength; history is not looked at.
    pure subroutine elastic_interface(self, modulus, strain, answer)
      import :: isotropic_model_type, answer_type, wp
      class(isotropic_model_type), intent(in) :: self
      !> Modulus of the step.
      real(wp), intent(in) :: modulus
      !> Principal elastic strains (3).
      real(wp), intent(in) :: strain(3)
      !> Stress and derivative.
      type(answer_type), intent(out) :: answer
    end subroutine elastic_interface

    !> The answer of the model.
    pure subroutine respond_interface(self, modulus, strain, history, with_derivative, answer)
      import :: isotropic_model_type, answer_type, wp
      class(isotropic_model_type), intent(in) :: self
      !> Modulus of the step.
      real(wp), intent(in) :: modulus
      !> Principal trial strains (3).
      real(wp), intent(in) :: strain(3)
      !> History at the start of the step (history_count).
      real(wp), intent(in) :: history(:)
      !> Whether the derivative is wanted.
      logical, intent(in) :: with_derivative
      !> The answer.
      type(answer_type), intent(out) :: answer
    end subroutine respond_interface
  end interface

contains

  !> Moduli of isotropic elasticity in principal values.
  pure function elastic_map(bulk, shear) result(map)
    !> Bulk modulus.
    real(wp), intent(in) :: bulk
    !> Shear modulus.
    real(wp), intent(in) :: shear
    real(wp) :: map(3, 3)

    map = bulk - 2.0_wp*shear/3.0_wp + 2.0_wp*shear*identity
  end function elastic_map
end module qsmpm_isotropic_model
