!> Check of exact beams for missing flexibility. The energy that functions they lack would save, of a vibration or of a buckling
!> shape, with the error of its frequency or load. Floor: monitor. Source: doc/theory, eqs. (7.66), (7.67).
module limber_monitor_function_checks
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text, newline
   use limber_monitor_function_watch, only: function_watch_type, start_functions, lacking_strains
   use limber_beam_exact_profile, only: of_ei, of_ea, of_ga
   use limber_model_model, only: model_type
   use limber_multibody_equilibrium, only: equilibrium_type, linearise_balance
   use limber_multibody_free_motions, only: find_freedom
   use limber_multibody_kinematics, only: move_frames
   use limber_multibody_sparse_eigenmodes, only: is_large
   use limber_multibody_layout, only: advance, velocities_of
   use limber_multibody_multiplier_system, only: update_jacobians
   use limber_multibody_system, only: system_type, workspace_type
   use limber_multibody_tangent, only: factor_masses, solve_refined
   use limber_multibody_small_vibrations, only: vibrations_type, find_vibrations, no_damping
   implicit none
   private
   public :: function_mode_warnings, function_load_warning, function_state_warning

   !> Largest relative error of a frequency, or of a load, that is not told, and above which its estimate is only a bound
   real(wp), parameter :: little = 2.0e-3_wp, beyond = 0.3_wp
   !> The same of the stiffness that loads leave, the squared frequency beside its elastic part: where that is less than
   !> `softened`, and where deflections err as it does, so that the first limit counts
   real(wp), parameter :: little_stiffness = 5.0e-2_wp, softened = 0.9_wp, compressed = 0.3_wp
   !> Motion to both sides of the state, in parts of a radian or of the scene
   real(wp), parameter :: aside = 1.0e-4_wp

contains

   !> A warning for the mode whose frequency errs most, and its beam; and for one that belongs among those that are listed. Empty if
   !> all are right.
   function function_mode_warnings(system, work, balance, t, q, lambda, vibrations, listed, is_damped, name, times, &
      & known) result(text)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Linearised at the state, and again so afterwards
      type(equilibrium_type), intent(inout) :: balance
      !> Time, coordinates (nq), multipliers of the state (nc)
      real(wp), intent(in) :: t, q(:), lambda(:)
      !> Without damping
      type(vibrations_type), intent(in) :: vibrations
      !> How many of them are listed, the first ones
      integer, intent(in) :: listed
      !> Whether the list is one with damping
      logical, intent(in) :: is_damped
      !> Of the analysis
      character(*), intent(in) :: name
      !> How many times beyond its limit an error must be
      real(wp), intent(in) :: times
      !> Errors of those that are listed, if they are known (listed): estimates then only tell the beam
      real(wp), allocatable, intent(in), optional :: known(:)
      character(:), allocatable :: text
      type(function_watch_type) :: watch
      real(wp), allocatable :: saved(:, :), part(:, :), of_worst(:)
      logical :: estimated
      real(wp) :: omega2, error, worst, last
      integer :: j, mode, beam, others
      text = ''
      call start_functions(watch, system)
      if (size(watch%beams) == 0) return
      allocate (saved(3, size(watch%beams)), part(3, size(watch%beams)), of_worst(3))
      worst = 0.0_wp
      last = 0.0_wp
      if (listed > 0) last = vibrations%frequency(listed)**2 + vibrations%growth(listed)**2
      mode = 0
      beam = 1
      others = -1
      estimated = .true.
      if (present(known)) estimated = .not. allocated(known)
      do j = 1, size(vibrations%frequency)
         omega2 = vibrations%frequency(j)**2 + vibrations%growth(j)**2
         call save(watch, system, work, balance, t, q, lambda, real(vibrations%shape(:, j), wp), saved)
         call save(watch, system, work, balance, t, q, lambda, aimag(vibrations%shape(:, j)), part)
         saved = saved + part
         ! A motion that nothing resists
         if (.not. omega2 > 1.0e-10_wp*maxval(vibrations%frequency)**2) cycle
         error = 1/sqrt(1 - min(sum(saved)/omega2, 0.99_wp)) - 1
         if (.not. estimated .and. j <= listed) error = known(j)
         if (j > listed) then
            beam = maxloc(sum(saved, dim=1), dim=1)
            ! Bending modes stay in their order, whatever is lacking
            if (text /= '' .or. error <= times*little .or. saved(2, beam) < 0.5_wp*sum(saved(:, beam))) cycle
            if (omega2/(1 + sum(saved)/omega2) >= last) cycle
            text = "warning: *MODES '"//name//"' may lack a mode: the one at "//as_text(vibrations%frequency(j), 4)// &
               & ' rad/'//system%model%units%time//trim(merge(' without damping', repeat(' ', 16), is_damped))// &
               & ', behind the last of the list, is too fast by '//size_words(error)//': '// &
               & remedy(system%model, watch%beams(beam)%body, saved(:, beam))//newline
            cycle
         end if
         if (error > times*little) others = others + 1
         if (error <= max(worst, times*little)) cycle
         worst = error
         mode = j
         beam = maxloc(sum(saved, dim=1), dim=1)
         of_worst = saved(:, beam)
      end do
      if (.not. worst > 0.0_wp) return
      beam = watch%beams(beam)%body
      text = text//'warning: mode '//as_text(mode)//" of *MODES '"//name//"'"
      if (is_damped) text = text//', at '//as_text(vibrations%frequency(mode), 4)//' rad/'//system%model%units%time// &
         & ' without damping,'
      if (others > 0) text = text//' (and '//as_text(others)//' more)'
      text = text//' errs in its frequency by '//size_words(worst, estimated)//': '// &
         & remedy(system%model, beam, of_worst)//newline
   end function function_mode_warnings

   !> A warning of the load at which the scene buckles in a motion; empty if it is right.
   function function_load_warning(system, work, balance, t, q, lambda, motion, taken) result(text)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> As of modes
      type(equilibrium_type), intent(inout) :: balance
      !> Time, coordinates (nq), multipliers (nc), motion without stiffness (nw)
      real(wp), intent(in) :: t, q(:), lambda(:), motion(:)
      !> Stiffness that the loads take from that motion, of unit size in the scales: less than the elastic one counts as that
      real(wp), intent(in) :: taken
      character(:), allocatable :: text
      type(function_watch_type) :: watch
      real(wp), allocatable :: saved(:, :)
      real(wp) :: error
      integer :: beam
      text = ''
      call start_functions(watch, system)
      if (size(watch%beams) == 0) return
      allocate (saved(3, size(watch%beams)))
      call save(watch, system, work, balance, t, q, lambda, motion, saved)
      error = sum(saved)/max(elastic_energy(system, motion), taken*norm2(motion/balance%scale)**2)
      beam = maxloc(sum(saved, dim=1), dim=1)
      if (error > little) text = 'warning: the load at t = '//as_text(t, 6)//', where equilibrium turns unstable, is too high by ' &
         & //size_words(error)//': '//remedy(system%model, watch%beams(beam)%body, saved(:, beam))//newline
   end function function_load_warning

   !> A warning of a state at rest whose softest vibration is so much softer with all functions that it is near buckling, or beyond;
   !> empty else.
   function function_state_warning(system, work, balance, t, q, lambda) result(text)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> As of modes
      type(equilibrium_type), intent(inout) :: balance
      !> Time, coordinates (nq), multipliers (nc)
      real(wp), intent(in) :: t, q(:), lambda(:)
      character(:), allocatable :: text
      type(function_watch_type) :: watch
      type(vibrations_type) :: vibrations
      type(error_type), allocatable :: error
      real(wp), allocatable :: saved(:, :)
      real(wp) :: part, left
      integer :: beam
      text = ''
      if (.not. any(system%model%bodies%reduced%is_exact) .or. is_large(system)) return
      call linearise_balance(system, work, balance, t, q, lambda)
      call find_freedom(system, work, .false., balance%freedom)
      if (size(balance%freedom%basis, 2) == 0) text = 'warning: joints and drivers leave the functions of exact beams no '// &
         & 'freedom at t = '//as_text(t, 6)//': they bear loads as if rigid; use more FUNCTIONS'//newline
      if (size(balance%freedom%basis, 2) == 0) return
      call find_vibrations(system, balance%tangent, balance%freedom, no_damping, 1, vibrations, error)
      if (allocated(error) .or. size(vibrations%frequency) == 0) return
      call start_functions(watch, system)
      allocate (saved(3, size(watch%beams)))
      call save(watch, system, work, balance, t, q, lambda, real(vibrations%shape(:, 1), wp), saved)
      if (.not. vibrations%frequency(1) > 0.0_wp) return
      part = sum(saved)/vibrations%frequency(1)**2
      left = vibrations%frequency(1)**2/elastic_energy(system, real(vibrations%shape(:, 1), wp))
      if (left > softened .or. part <= merge(little, little_stiffness, left < compressed)) return
      text = 'warning: the loads at t = '//as_text(t, 6)//' leave less stiffness than the functions tell, which is too high by '// &
         & size_words(part)
      if (part > 1.0_wp) text = text//' (the scene may have buckled before)'
      beam = maxloc(sum(saved, dim=1), dim=1)
      text = text//': '//remedy(system%model, watch%beams(beam)%body, saved(:, beam))//newline
   end function function_state_warning

   !> Elastic energy of a motion, times two.
   pure real(wp) function elastic_energy(system, motion) result(energy)
      type(system_type), intent(in) :: system
      !> In the layout of the rates (nw)
      real(wp), intent(in) :: motion(:)
      integer :: i, first, last
      energy = tiny(energy)
      do i = 1, size(system%model%bodies)
         if (system%layout%n(i) == 0) cycle
         first = system%layout%w(i) + 3
         last = first - 1 + system%layout%n(i)
         energy = energy + sum(system%model%bodies(i)%reduced%omega2*motion(first:last)**2)
      end do
   end function elastic_energy

   function size_words(error, estimated) result(text)
      real(wp), intent(in) :: error
      !> Whether large errors are only bounds, as they are without it
      logical, intent(in), optional :: estimated
      character(:), allocatable :: text
      logical :: bounded
      bounded = .true.
      if (present(estimated)) bounded = estimated
      text = 'about '
      if (error > beyond .and. bounded) text = 'more than '
      text = text//as_text(100*merge(min(error, beyond), error, bounded), 2)//' %'
   end function size_words

   !> The beam and its remedy: functions of what saves most.
   function remedy(model, body, saved) result(text)
      type(model_type), intent(in) :: model
      integer, intent(in) :: body
      !> Energies of the bending, the stretching and the shear (3)
      real(wp), intent(in) :: saved(3)
      character(:), allocatable :: text
      associate (own => model%bodies(body))
         if (own%whole > 0) then
            text = "'"//model%wholes(own%whole)%name//"'"
         else
            text = "'"//own%name//"'"
         end if
         text = 'beam '//text//' has too few functions for this shape; use '
         if (saved(2) > 0.5_wp*sum(saved)) then
            text = text//'STRAIN FUNCTIONS='//as_text(max(2, 2*own%choice%exact%strains))
         else
            text = text//'FUNCTIONS='//as_text(2*own%choice%exact%angles)
         end if
      end associate
   end function remedy

   !> Energy, times two, that each beam would save with all functions in a motion from the state, eq. (7.66): the strains that
   !> equilibrium asks for beside the state, less those that the functions make.
   subroutine save(watch, system, work, balance, t, q, lambda, motion, saved)
      type(function_watch_type), intent(inout) :: watch
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(equilibrium_type), intent(inout) :: balance
      real(wp), intent(in) :: t, q(:), lambda(:)
      !> In the layout of the rates (nw)
      real(wp), intent(in) :: motion(:)
      !> That of the bending, the stretching and the shear (3, beams)
      real(wp), intent(out) :: saved(:, :)
      real(wp), allocatable :: lack(:, :), lacks(:, :, :)
      real(wp) :: a(size(q)), step, largest
      logical :: done
      integer :: i, side, most
      saved = 0.0_wp
      largest = maxval(abs(motion)/balance%scale)
      if (.not. largest > 0.0_wp) return
      step = aside/largest
      most = 0
      do i = 1, size(watch%beams)
         most = max(most, size(watch%beams(i)%recovery%sections))
      end do
      allocate (lacks(3, most, size(saved, 2)))
      lacks = 0.0_wp
      do side = -1, 1, 2
         call go_aside(system, work, balance, t, q, lambda, side*step*motion, a, done)
         if (.not. done) exit
         do i = 1, size(saved, 2)
            call lacking_strains(watch, system, work, i, balance%moved, balance%v, a, lack)
            lacks(:, :size(lack, 2), i) = lacks(:, :size(lack, 2), i) + side*lack/(2*step)
         end do
      end do
      call linearise_balance(system, work, balance, t, q, lambda)
      work%lambda = lambda
      call update_jacobians(system, work)
      if (.not. done) return
      do i = 1, size(saved, 2)
         associate (exact => system%model%bodies(watch%beams(i)%body)%reduced%exact)
            associate (own => lacks(:, :exact%stations, i))
               saved(:, i) = [sum(exact%weight*exact%section(of_ei, :)*own(1, :)**2), &
                  & sum(exact%weight*exact%section(of_ea, :)*own(2, :)**2), sum(exact%weight*exact%section(of_ga, :)*own(3, :)**2)]
            end associate
         end associate
      end do
   end subroutine save

   !> Places the scene beside the state, with the accelerations and multipliers that it has there; the place is in balance%moved.
   subroutine go_aside(system, work, balance, t, q, lambda, motion, a, done)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(equilibrium_type), intent(inout) :: balance
      real(wp), intent(in) :: t, q(:), lambda(:), motion(:)
      !> (nq)
      real(wp), intent(out) :: a(:)
      logical, intent(out) :: done
      real(wp) :: moved(size(q))
      logical :: singular
      moved = q
      call advance(system%layout, q, motion, moved)
      call linearise_balance(system, work, balance, t, moved, lambda)
      balance%moved = moved
      call factor_masses(balance%tangent, singular)
      done = .not. singular
      if (singular) return
      associate (nw => system%layout%nw, solution => balance%solution)
         solution(:nw) = -balance%motion
         solution(nw + 1:) = 0.0_wp
         call solve_refined(balance%tangent, nw, solution, balance%correction)
         a = 0.0_wp
         call velocities_of(system%layout, moved, solution(:nw), a)
         a = a + balance%a
         work%lambda = lambda + solution(nw + 1:)
      end associate
      call move_frames(system%model, system%layout, moved, balance%v, work%kinematics)
      call update_jacobians(system, work)
   end subroutine go_aside

end module limber_monitor_function_checks
