!> Check of static shapes of exact beams by a second scene. Where equilibrium at the place of the functions says that these may lack
!> something, the scene with twice the functions of the angle is brought into equilibrium aside, and each axis and its
!> bending moments are compared with its own. Floor: analysis. Source: doc/theory, eqs. (7.49), (7.54).
!>
!>     call compare_shapes(self, scene, sample, watch)   ! at each sample
!>     call tell_shapes(self, watch)                     ! at the end
module limber_analysis_shape_aside
   use limber_base_kinds, only: wp
   use limber_analysis_richer_scene, only: nothing_more, with_angles
   use limber_analysis_scene_aside, only: aside_type, build_aside, place_aside
   use limber_analysis_static_aside, only: aside_sample_type
   use limber_scene_scene, only: scene_type
   use limber_beam_exact_beam, only: exact_type, reach_of, panel_stations
   use limber_beam_force_recovery, only: recovery_type
   use limber_beam_taut_axis, only: locate, values_at
   use limber_model_force_sections, only: recover_stations
   use limber_output_exact_forces, only: find_lack, settle_stations
   use limber_output_internal_forces, only: section_forces_type, start_effort, gather_exact
   use limber_multibody_equilibrium, only: linearise_balance
   use limber_multibody_kinematics, only: place_frames, move_frames
   use limber_multibody_multiplier_system, only: update_jacobians
   use limber_multibody_system, only: system_type
   use limber_monitor_function_watch, only: function_watch_type, beam_watch_type
   use limber_multibody_plane_vectors, only: along, cross
   use limber_multibody_sparse_eigenmodes, only: is_large
   implicit none
   private
   public :: shape_aside_type, compare_shapes, tell_shapes

   !> Part of the largest deflection that equilibrium must ask for: it may be twenty times too small
   real(wp), parameter :: doubtful = 1.0e-4_wp

   !> What the stations of a beam, and those of the richer one, give to the places of its stations and its end (stations, places);
   !> parts of its length where these are (places)
   type :: reach_type
      real(wp), allocatable :: own(:, :), other(:, :), part(:)
      !> Where the stations are in the panels of the richer one: panels (stations), and what the stations of these give to values
      !> there (stations of a panel, stations)
      integer, allocatable :: panel(:)
      real(wp), allocatable :: value(:, :)
      !> Section forces of the richer one at its stations
      type(recovery_type) :: recovery
      type(section_forces_type) :: effort
   end type reach_type

   !> The scene aside, and what was compared so far
   type :: shape_aside_type
      type(aside_type) :: aside
      !> Whether it was built, can be used, and had no equilibrium at some sample
      logical :: tried = .false., used = .false., failed = .false.
      type(reach_type), allocatable :: reach(:)
      !> Largest differences, and when; largest difference of bending moments, and largest moment (exact beams)
      real(wp), allocatable :: off(:), when(:), moment_off(:), moment(:)
   end type shape_aside_type

contains

   !> Compares the shapes at a sample.
   subroutine compare_shapes(self, scene, sample, watch)
      type(shape_aside_type), intent(inout) :: self
      type(scene_type), intent(in) :: scene
      type(aside_sample_type), intent(in) :: sample
      !> What has been seen so far
      type(function_watch_type), intent(in) :: watch
      real(wp) :: off
      logical :: done
      integer :: i
      if (size(watch%beams) == 0 .or. is_large(scene%system)) return
      if (.not. any(watch%beams%left_out(1) > doubtful*watch%beams%moved_by_angle)) return
      if (.not. self%tried) call build(self, scene, watch)
      if (.not. self%used) return
      call place_aside(scene, sample%t, sample%q, sample%lambda, .true., sample%rotation, sample%centre, self%aside, done)
      self%failed = self%failed .or. .not. done
      if (.not. done) return
      call place_motion(self, sample%t)
      do i = 1, size(watch%beams)
         call compare_moments(self, scene, sample%q, watch%beams(i), i)
         off = difference(self, scene, sample%q, watch%beams(i)%body, i)
         if (off <= self%off(i)) cycle
         self%off(i) = off
         self%when(i) = sample%t
      end do
   end subroutine compare_shapes

   !> Builds the scene aside.
   subroutine build(self, scene, watch)
      type(shape_aside_type), intent(inout) :: self
      type(scene_type), intent(in) :: scene
      type(function_watch_type), intent(in) :: watch
      integer :: i, k
      self%tried = .true.
      call build_aside(scene, merge(with_angles, nothing_more, scene%system%model%bodies%reduced%is_exact), 0, .false., &
         & self%aside, self%used)
      if (.not. self%used) return
      associate (n => size(watch%beams))
         allocate (self%off(n), self%when(n), self%moment_off(n), self%moment(n), source=0.0_wp)
      end associate
      allocate (self%reach(size(watch%beams)))
      do i = 1, size(watch%beams)
         associate (own => scene%system%model%bodies(watch%beams(i)%body)%reduced%exact, &
            & richer => self%aside%scene%system%model%bodies(watch%beams(i)%body)%reduced%exact)
            associate (reach => self%reach(i), places => own%stations + 1)
               allocate (reach%own(own%stations, places), reach%other(richer%stations, places), reach%part(places))
               reach%part = [own%s, own%total]
               do k = 1, places
                  reach%own(:, k) = reach_of(own, reach%part(k)) - own%base
                  reach%other(:, k) = reach_of(richer, reach%part(k)) - richer%base
               end do
               reach%part = reach%part/own%total
               call find_panels(own, richer, reach)
               call recover_stations(self%aside%scene%system%model, watch%beams(i)%body, reach%recovery)
               call start_effort(reach%effort, self%aside%scene%system, watch%beams(i)%body, reach%recovery)
            end associate
         end associate
      end do
   end subroutine build

   !> The places of the stations of a beam in the panels of the richer one.
   pure subroutine find_panels(own, richer, reach)
      type(exact_type), intent(in) :: own, richer
      type(reach_type), intent(inout) :: reach
      real(wp) :: x
      integer :: k
      allocate (reach%panel(own%stations), reach%value(panel_stations, own%stations))
      do k = 1, own%stations
         call locate(richer, own%s(k), .false., reach%panel(k), x)
         reach%value(:, k) = values_at(x)
      end do
   end subroutine find_panels

   !> Kinematics, Jacobians and multipliers of the scene aside, where it was brought into equilibrium.
   subroutine place_motion(self, t)
      type(shape_aside_type), intent(inout) :: self
      real(wp), intent(in) :: t
      associate (new => self%aside%scene, balance => self%aside%balance)
         call linearise_balance(new%system, new%work, balance, t, new%q, new%last%lambda)
         call place_frames(new%system%model, new%system%layout, t, new%q, new%work%kinematics)
         call move_frames(new%system%model, new%system%layout, new%q, balance%v, new%work%kinematics)
         call update_jacobians(new%system, new%work)
         new%work%lambda = new%last%lambda
      end associate
   end subroutine place_motion

   !> Compares the bending moments at the stations of a beam.
   subroutine compare_moments(self, scene, q, beam, which)
      type(shape_aside_type), intent(inout) :: self
      type(scene_type), intent(in) :: scene
      !> (nq)
      real(wp), intent(in) :: q(:)
      !> As it was seen there; its place among the exact beams
      type(beam_watch_type), intent(in) :: beam
      integer, intent(in) :: which
      !> Moment that is none, relative to the largest force and the length of the beam: round-off of a beam that only stretches
      real(wp), parameter :: none = 1.0e-8_wp
      real(wp), allocatable :: own(:), other(:)
      real(wp) :: there
      integer :: k, first
      associate (new => self%aside%scene, reach => self%reach(which))
         self%moment(which) = max(self%moment(which), none*maxval(abs(beam%effort%exact(:2, :)))* &
            & scene%system%model%bodies(beam%body)%reduced%exact%total)
         call gather_exact(reach%effort, new%system, new%work, beam%body, reach%recovery, new%q, self%aside%balance%v, &
            & self%aside%balance%a)
         call settled_moments(scene%system, beam%body, q, beam%effort%exact, own)
         call settled_moments(new%system, beam%body, new%q, reach%effort%exact, other)
         do k = 1, size(own)
            first = panel_stations*(reach%panel(k) - 1)
            there = dot_product(reach%value(:, k), other(first + 1:first + panel_stations))
            self%moment_off(which) = max(self%moment_off(which), abs(own(k) - there))
            self%moment(which) = max(self%moment(which), abs(there))
         end do
      end associate
   end subroutine compare_moments

   !> Bending moments as they are reported, eq. (2.64) (stations).
   subroutine settled_moments(system, body, q, forces, moments)
      type(system_type), intent(in) :: system
      integer, intent(in) :: body
      !> (nq)
      real(wp), intent(in) :: q(:)
      !> By equilibrium (3, stations)
      real(wp), intent(in) :: forces(:, :)
      real(wp), allocatable, intent(out) :: moments(:)
      real(wp) :: settled(3, size(forces, 2)), lack(3, size(forces, 2)), at_rest(system%layout%n(body))
      integer :: first
      first = system%layout%q(body) + 4
      at_rest = 0.0_wp
      settled = forces
      associate (eta => q(first:first - 1 + system%layout%n(body)))
         call find_lack(system%model%bodies(body), settled, eta, at_rest, lack)
         call settle_stations(system%model%bodies(body), eta, lack(1, :), settled)
      end associate
      allocate (moments, source=settled(3, :))
   end subroutine settled_moments

   !> Largest distance of the axis of a beam from its own, in its frame; from the chord where that is held, or from the place
   !> where it is nearest where the section at the origin may turn.
   pure real(wp) function difference(self, scene, q, body, which) result(largest)
      type(shape_aside_type), intent(in) :: self
      type(scene_type), intent(in) :: scene
      !> (nq)
      real(wp), intent(in) :: q(:)
      !> Index of the body, and among the exact beams
      integer, intent(in) :: body, which
      real(wp), allocatable :: slope(:, :), place(:, :), other(:, :)
      real(wp) :: turned
      integer :: k, a, b
      associate (system => scene%system, richer => self%aside%scene%system, reach => self%reach(which))
         a = system%layout%q(body) + 4
         b = richer%layout%q(body) + 4
         associate (exact => system%model%bodies(body)%reduced%exact, rich => richer%model%bodies(body)%reduced%exact, &
            & support => system%model%bodies(body)%choice%exact%support, last => size(reach%own, 2))
            allocate (slope(2, rich%stations), place(2, last), other(2, last))
            slope(:, :) = axis_slope(rich, self%aside%scene%q(b:b + rich%n - 1))
            other(:, :) = matmul(slope, reach%other)
            deallocate (slope)
            allocate (slope(2, exact%stations))
            slope(:, :) = axis_slope(exact, q(a:a + exact%n - 1))
            place(:, :) = matmul(slope, reach%own)
            other = other - place
            if (support%w_end) then
               do k = 1, last
                  other(:, k) = other(:, k) - reach%part(k)*other(:, last)
               end do
            else if (.not. (support%theta_start .or. exact%shifted)) then
               turned = sum([(cross(place(:, k), other(:, k)), k=1, last)])/sum(place**2)
               other(1, :) = other(1, :) + turned*place(2, :)
               other(2, :) = other(2, :) - turned*place(1, :)
            end if
            largest = maxval(norm2(other, dim=1))
         end associate
      end associate
   end function difference

   !> Derivative of the place along the axis, eq. (2.31) (2, stations).
   pure function axis_slope(exact, eta) result(slope)
      type(exact_type), intent(in) :: exact
      !> (n)
      real(wp), intent(in) :: eta(:)
      real(wp) :: slope(2, exact%stations), angle
      integer :: k
      do k = 1, exact%stations
         angle = exact%lean(k) + dot_product(exact%psi(:, k), eta(:exact%angles))
         slope(:, k) = along([1.0_wp + dot_product(exact%chi(1, :, k), eta(exact%angles + 1:)), &
            & dot_product(exact%chi(2, :, k), eta(exact%angles + 1:))], [cos(angle), sin(angle)])
      end do
   end function axis_slope

   !> Puts what was found in the place of what equilibrium asked for; where some sample could not be compared, the larger one.
   pure subroutine tell_shapes(self, watch)
      type(shape_aside_type), intent(in) :: self
      type(function_watch_type), intent(inout) :: watch
      integer :: i
      if (.not. self%used) return
      do i = 1, size(watch%beams)
         watch%beams(i)%moment_off = max(watch%beams(i)%moment_off, self%moment_off(i))
         watch%beams(i)%moment = max(watch%beams(i)%moment, self%moment(i))
         if (self%failed .and. watch%beams(i)%left_out(1) >= self%off(i)) cycle
         watch%beams(i)%left_out(1) = self%off(i)
         watch%beams(i)%when(1) = self%when(i)
      end do
   end subroutine tell_shapes

end module limber_analysis_shape_aside
