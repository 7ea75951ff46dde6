!> Check of vibrations that grow about an equilibrium. Coordinates that are no vibrations of their own, as static functions, may
!> flutter where more modes do not: such vibrations do not count. Floor: analysis. Source: doc/theory, eqs. (6.10), (7.49).
module limber_analysis_flutter_aside
   use limber_base_text, only: as_text
   use limber_base_kinds, only: wp
   use limber_analysis_richer_scene, only: can_enrich, nothing_more, with_both
   use limber_analysis_scene_aside, only: aside_type, build_aside, place_aside, additional_modes
   use limber_scene_scene, only: scene_type
   use limber_multibody_equilibrium, only: equilibrium_type, linearise_balance
   use limber_multibody_sparse_eigenmodes, only: is_large
   use limber_multibody_stability, only: judge
   implicit none
   private
   public :: check_flutter

   !> Modes that each body gets beside its own
   integer, parameter :: more = 12
   !> Part of a frequency that another one may differ by, to be that of the same vibration
   real(wp), parameter :: near = 0.2_wp

contains

   !> Looks at a vibration that grows in a scene with more modes. If none that is near it grows there, it and all faster ones
   !> do not count any more, and the stability is judged anew.
   subroutine check_flutter(scene, balance, t, q, lambda, text)
      type(scene_type), intent(inout) :: scene
      !> Judged at the place: it flutters
      type(equilibrium_type), intent(inout) :: balance
      !> Time, coordinates (nq) and multipliers (nc) of the equilibrium
      real(wp), intent(in) :: t, q(:), lambda(:)
      !> What the user is told; empty if the vibration counts
      character(:), allocatable, intent(out) :: text
      type(aside_type), allocatable :: aside
      integer :: level(size(scene%system%model%bodies))
      logical :: done
      text = ''
      level = merge(with_both, nothing_more, can_enrich(scene%system%model%bodies))
      if (balance%confirmed .or. all(level == nothing_more) .or. is_large(scene%system)) return
      allocate (aside)
      call build_aside(scene, level, additional_modes(scene%system, level, more), .false., aside, done)
      if (done) call place_aside(scene, t, q, lambda, .true., balance%rotation, balance%centre, aside, done)
      if (done) then
         associate (new => aside%scene)
            call linearise_balance(new%system, new%work, aside%balance, t, new%q, new%last%lambda)
            call judge(new%system, new%work, aside%balance, new%last%lambda)
         end associate
         done = .not. (aside%balance%flutters .and. aside%balance%frequency < (1 + near)*balance%frequency)
      end if
      balance%confirmed = .not. done
      if (balance%confirmed) return
      text = 'vibrations at '//as_text(balance%frequency, 5)//' rad/'//scene%system%model%units%time//' grow at t = '// &
         & as_text(t, 8)//', but not with more modes: they and faster ones do not count; use more MODES to have'// &
         & ' them judged'
      balance%fastest = (1 - near)*balance%frequency
      call linearise_balance(scene%system, scene%work, balance, t, q, lambda)
      call judge(scene%system, scene%work, balance, lambda)
   end subroutine check_flutter

end module limber_analysis_flutter_aside
