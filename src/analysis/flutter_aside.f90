!> Check of vibrations that grow about an equilibrium. Coordinates that are no vibrations of their own, as static functions, may
!> flutter where more modes do not: such vibrations do not count. Floor: analysis. Source: doc/theory, eqs. (6.10), (7.49).
!>
!>     call check_flutter(self, scene, balance, t, q, lambda)   ! balance%flutters is false if they do not count
module limber_analysis_flutter_aside
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_analysis_richer_scene, only: can_enrich, nothing_more, with_both
   use limber_analysis_scene_aside, only: aside_type, build_aside, place_aside, additional_modes
   use limber_scene_scene, only: scene_type
   use limber_multibody_equilibrium, only: equilibrium_type, linearise_balance
   use limber_multibody_sparse_eigenmodes, only: is_large
   use limber_multibody_stability, only: judge
   implicit none
   private
   public :: flutter_aside_type, check_flutter

   !> Modes that each body gets beside its own
   integer, parameter :: more = 12
   !> Part of a frequency that another one may differ by, to be that of the same vibration
   real(wp), parameter :: near = 0.2_wp

   !> The scene with more modes
   type :: flutter_aside_type
      type(aside_type), allocatable :: aside
      !> Whether it was built, and whether it could be
      logical :: asked = .false., used = .false.
      !> What the user is told: the first vibration that did not count; unallocated if all did
      character(:), allocatable :: text
   end type flutter_aside_type

contains

   !> Looks at a vibration that grows in a scene with more modes. If none that is near it grows there, it and all faster ones
   !> do not count at this place, and the stability is judged without them.
   subroutine check_flutter(self, scene, balance, t, q, lambda)
      type(flutter_aside_type), intent(inout) :: self
      type(scene_type), intent(inout) :: scene
      !> Judged at the place: it flutters
      type(equilibrium_type), intent(inout) :: balance
      !> Time, coordinates (nq) and multipliers (nc) of the equilibrium
      real(wp), intent(in) :: t, q(:), lambda(:)
      logical :: done
      if (.not. self%asked) call build(self, scene)
      do while (self%used .and. balance%flutters)
         call place_aside(scene, t, q, lambda, .true., balance%rotation, balance%centre, self%aside, done)
         if (.not. done) exit
         associate (new => self%aside%scene, other => self%aside%balance)
            call linearise_balance(new%system, new%work, other, t, new%q, new%last%lambda)
            call judge(new%system, new%work, other, new%last%lambda)
            if (other%flutters .and. other%frequency < (1 + near)*balance%frequency) exit
         end associate
         if (.not. allocated(self%text)) self%text = 'vibrations at '//as_text(balance%frequency, 5)//' rad/'// &
            & scene%system%model%units%time//' grow at t = '//as_text(t, 8)//', but not with more modes: they do not count'// &
            & ' there; use more MODES'
         balance%fastest = (1 - near)*balance%frequency
         call judge(scene%system, scene%work, balance, lambda)
      end do
      balance%fastest = huge(balance%fastest)
   end subroutine check_flutter

   !> Builds the scene with more modes.
   subroutine build(self, scene)
      type(flutter_aside_type), intent(inout) :: self
      type(scene_type), intent(in) :: scene
      integer :: level(size(scene%system%model%bodies))
      self%asked = .true.
      level = merge(with_both, nothing_more, can_enrich(scene%system%model%bodies))
      if (all(level == nothing_more) .or. is_large(scene%system)) return
      allocate (self%aside)
      call build_aside(scene, level, additional_modes(scene%system, level, more), .false., self%aside, self%used)
   end subroutine build

end module limber_analysis_flutter_aside
