!> Check of static shapes of exact beams by a second scene. Where equilibrium at the place of the functions says that these may lack
!> something, the scene with twice the functions of the angle is brought into equilibrium aside, and each axis is compared with its
!> own. Floor: analysis. Source: doc/theory, eqs. (7.49), (7.54).
!>
!>     call compare_shapes(self, scene, sample, watch)   ! at each sample
!>     call tell_shapes(self, watch)                     ! at the end
module limber_analysis_shape_aside
   use limber_base_kinds, only: wp
   use limber_analysis_richer_scene, only: nothing_more, with_angles
   use limber_analysis_scene_aside, only: aside_type, build_aside, place_aside
   use limber_analysis_static_aside, only: aside_sample_type
   use limber_scene_first_scene, only: scene_type
   use limber_beam_exact_beam, only: exact_type, reach_of
   use limber_monitor_function_watch, only: function_watch_type
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
   end type reach_type

   !> The scene aside, and what was compared so far
   type :: shape_aside_type
      type(aside_type) :: aside
      !> Whether it was built, can be used, and had no equilibrium at some sample
      logical :: tried = .false., used = .false., failed = .false.
      type(reach_type), allocatable :: reach(:)
      !> Largest differences, and when (exact beams)
      real(wp), allocatable :: off(:), when(:)
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
      do i = 1, size(watch%beams)
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
      allocate (self%off(size(watch%beams)), self%when(size(watch%beams)), source=0.0_wp)
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
            end associate
         end associate
      end do
   end subroutine build

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
         if (self%failed .and. watch%beams(i)%left_out(1) >= self%off(i)) cycle
         watch%beams(i)%left_out(1) = self%off(i)
         watch%beams(i)%when(1) = self%when(i)
      end do
   end subroutine tell_shapes

end module limber_analysis_shape_aside
