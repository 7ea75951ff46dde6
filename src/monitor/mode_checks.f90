!> Check of the frequencies of a modal analysis. Mode by mode and body by body, against what the mesh of each flexible body does
!> under the axial forces that act, and with its mass where it is. Floor: monitor. Source: doc/theory, eqs. (7.22), (7.28), (7.52).
module limber_monitor_mode_checks
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text, newline
   use limber_monitor_body_surveys, only: surveys_type, body_survey_type, start_surveys, take_amplitudes
   use limber_beam_elastic_forces, only: coriolis_power
   use limber_beam_mesh_forces, only: axial_work, mass_error
   use limber_beam_reduced_body, only: reduced_type
   use limber_model_model, only: body_type
   use limber_multibody_plane_vectors, only: along
   use limber_multibody_system, only: system_type, workspace_type
   use limber_multibody_small_vibrations, only: vibrations_type
   implicit none
   private
   public :: mode_warnings

   !> Kinds of errors of a frequency: axial forces that a model lacks, masses in the nodes; and of a damping ratio: the Coriolis
   !> force of the shortening
   integer, parameter :: by_tension = 1, by_lumping = 2, by_shortening = 3, kinds = 3
   !> Largest relative errors of a frequency, and the largest error of a damping ratio, that are not told
   real(wp), parameter :: little = 0.02_wp, limit(kinds) = [little, little, 2.0e-4_wp]
   !> Relative error of a frequency above which its estimate is only a bound
   real(wp), parameter :: beyond = 0.5_wp

   !> The worst of one kind
   type :: worst_type
      real(wp) :: error = 0.0_wp
      integer :: mode = 0, body = 0, others = 0
   end type worst_type

contains

   !> Warnings, one for each kind of error, of the mode and the body that are worst; empty if all frequencies are within 2 %, and
   !> all damping ratios are those of the scene.
   function mode_warnings(system, work, q, v, a, rotation, vibrations, name) result(text)
      type(system_type), intent(in) :: system
      !> Kinematics and Jacobians of the state, with its multipliers
      type(workspace_type), intent(in) :: work
      !> Coordinates, velocities, accelerations (nq); speed of the steady rotation
      real(wp), intent(in) :: q(:), v(:), a(:), rotation
      type(vibrations_type), intent(in) :: vibrations
      !> Of the analysis
      character(*), intent(in) :: name
      character(:), allocatable :: text
      type(surveys_type) :: surveys
      type(worst_type) :: worst(kinds)
      real(wp) :: errors(kinds), largest, omega2
      integer :: i, j, k
      text = ''
      call start_surveys(surveys, system, .false.)
      call take_amplitudes(surveys, system, work, q, v, a)
      largest = 0.0_wp
      if (size(vibrations%frequency) > 0) largest = maxval(vibrations%frequency**2 + vibrations%growth**2)
      do i = 1, size(surveys%bodies)
         if (surveys%of(surveys%bodies(i)%body) == 0) cycle
         do j = 1, size(vibrations%frequency)
            omega2 = vibrations%frequency(j)**2 + vibrations%growth(j)**2
            if (.not. vibrations%frequency(j) > 0.0_wp) omega2 = -vibrations%growth(j)**2
            ! A motion that nothing resists
            if (abs(omega2) <= 1.0e-10_wp*largest) cycle
            call judge(system, q, surveys%bodies(i), vibrations%shape(:, j), omega2, rotation, errors)
            do k = 1, kinds
               if (.not. errors(k) > limit(k)) cycle
               if (worst(k)%body > 0) worst(k)%others = worst(k)%others + 1
               if (.not. errors(k) > worst(k)%error) cycle
               worst(k)%error = errors(k)
               worst(k)%mode = j
               worst(k)%body = surveys%bodies(i)%body
            end do
         end do
      end do
      do k = 1, kinds
         if (worst(k)%body > 0) text = text//warning(k, worst(k), system%model%bodies(worst(k)%body), name)
      end do
   end function mode_warnings

   !> Relative errors of the frequency of a mode by one body, of each kind, and of its damping ratio.
   subroutine judge(system, q, own, shape, omega2, rotation, errors)
      type(system_type), intent(in) :: system
      !> Coordinates (nq)
      real(wp), intent(in) :: q(:)
      type(body_survey_type), intent(in) :: own
      !> Of the mode, of unit modal mass (nw)
      complex(wp), intent(in) :: shape(:)
      !> Its squared frequency; speed of the steady rotation
      real(wp), intent(in) :: omega2, rotation
      real(wp), intent(out) :: errors(kinds)
      real(wp), allocatable :: u(:, :)
      real(wp) :: lack, more, lost, w(3 + system%layout%n(own%body))
      integer :: at, first, n, k
      at = system%layout%w(own%body)
      first = system%layout%q(own%body)
      n = system%layout%n(own%body)
      lack = 0.0_wp
      more = 0.0_wp
      lost = 0.0_wp
      allocate (u(3, size(own%survey%mesh%place, 2)))
      do k = 1, 2
         if (k == 1) w = real(shape(at:at + 2 + n), wp)
         if (k == 2) w = aimag(shape(at:at + 2 + n))
         if (.not. maxval(abs(w)) > 0.0_wp) cycle
         call compare_work(system%model%bodies(own%body), own, q(first + 4:first + 3 + n), w(4:), lack)
         call add_lost(system%model%bodies(own%body)%reduced, rotation, q(first + 4:first + 3 + n), w(4:), lost)
         call displace(own, q(first + 2:first + 3), w, u)
         more = more + mass_error(own%survey%mesh, u)
      end do
      errors(by_tension) = 0.0_wp
      if (abs(lack) > 0.0_wp) errors(by_tension) = abs(sqrt(abs(omega2)/max(abs(omega2 + lack), 1.0e-4_wp*abs(omega2))) - 1)
      errors(by_lumping) = 0.5_wp*abs(more)
      errors(by_shortening) = 0.5_wp*abs(lost)/sqrt(abs(omega2))
   end subroutine judge

   !> Power that a shape loses by what the model lacks of the shortening, eq. (7.22), of unit velocity.
   subroutine add_lost(reduced, rotation, eta, w, lost)
      type(reduced_type), intent(in) :: reduced
      !> Speed of the steady rotation; coordinates of the state and of the shape (n)
      real(wp), intent(in) :: rotation, eta(:), w(:)
      !> Sum of it
      real(wp), intent(inout) :: lost
      real(wp) :: room(reduced%n), s(size(reduced%cubic, 1)), power
      if (.not. reduced%geometric) return
      call coriolis_power(reduced, rotation, eta, w, room, s, power)
      lost = lost + power
   end subroutine add_lost

   !> Work on a shape of the axial forces that act, less that of those which the model has, eq. (7.52).
   subroutine compare_work(body, own, eta, w, lack)
      type(body_type), intent(in) :: body
      type(body_survey_type), intent(in) :: own
      !> Coordinates of the state and of the shape (n)
      real(wp), intent(in) :: eta(:), w(:)
      !> Sum of that of the forces that the model lacks
      real(wp), intent(inout) :: lack
      real(wp) :: tension(0:size(own%survey%chosen), 0:size(own%survey%chosen)), s(size(body%reduced%cubic, 1)), part
      integer :: i, j, p
      call axial_work(own%survey, own%amplitude, tension)
      part = 0.0_wp
      do j = 1, size(own%survey%chosen)
         do i = 1, size(own%survey%chosen)
            part = part + tension(i, j)*w(own%survey%chosen(i))*w(own%survey%chosen(j))
         end do
      end do
      lack = lack + part
      if (.not. body%reduced%geometric) return
      s = matmul(body%reduced%cubic, eta(body%reduced%offset + 1:))
      p = 0
      do j = 1, body%reduced%bending
         do i = 1, j
            p = p + 1
            lack = lack - 2*s(p)*w(i)*w(j)
         end do
      end do
   end subroutine compare_work

   !> Displacements of the nodes in the axes of the body.
   pure subroutine displace(own, axis, w, u)
      type(body_survey_type), intent(in) :: own
      !> Unit vector of the body; motion along the fixed axes, rotation, coordinates (3 + n)
      real(wp), intent(in) :: axis(2), w(:)
      !> (3, nodes)
      real(wp), intent(out) :: u(:, :)
      real(wp) :: moved(2)
      integer :: k
      moved = along(w(1:2), [axis(1), -axis(2)])
      associate (place => own%survey%mesh%place)
         u(1, :) = moved(1) - w(3)*place(2, :)
         u(2, :) = moved(2) + w(3)*place(1, :)
      end associate
      u(3, :) = w(3)
      do k = 1, size(w) - 3
         u = u + own%survey%shape(:, :, k)*w(3 + k)
      end do
   end subroutine displace

   !> One line: what is wrong, of which mode and body, and what to do.
   function warning(kind, worst, body, name) result(text)
      integer, intent(in) :: kind
      type(worst_type), intent(in) :: worst
      type(body_type), intent(in) :: body
      character(*), intent(in) :: name
      character(:), allocatable :: text
      character(:), allocatable :: fidelity, cure
      fidelity = 'LINEAR'
      if (body%reduced%geometric) fidelity = 'K_G'
      text = "warning: mode "//as_text(worst%mode)//" of *MODES '"//name//"'"
      if (worst%others > 0) text = text//' (and '//as_text(worst%others)//' more)'
      if (kind == by_shortening) then
         text = text//' has a damping ratio that errs by about '//as_text(worst%error, 2)//': '// &
            & trim(merge('frame', 'beam ', body%is_frame))//" '"//body%name//"' rotates while it is bent, and K_G leaves out"// &
            & ' the Coriolis force of its shortening, which damps or feeds its vibrations; use '// &
            & trim(merge('LARGE=YES      ', 'GEOMETRIC=EXACT', body%is_frame))//newline
         return
      end if
      text = text//' errs in its frequency by '
      if (worst%error > beyond) text = text//'more than '
      text = text//'about '//as_text(100*min(worst%error, beyond), 2)//' %: '// &
         & trim(merge('frame', 'beam ', body%is_frame))//" '"//body%name//"' "
      select case (kind)
      case (by_tension)
         text = text//'carries axial forces that '//fidelity//' leaves out'
         cure = trim(merge('use GEOMETRIC=K_G  ', 'use GEOMETRIC=EXACT', body%is_frame))
         if (body%reduced%geometric) then
            text = text//' in part: its axial functions or k_G elements cannot follow them'
            cure = 'use GEOMETRIC=EXACT'
            if (body%is_frame) cure = merge('use LARGE=YES      ', 'use CORRECTIONS=YES', body%frame_choice%accelerations)
         end if
      case default
         text = text//'has too few elements: its mass is in their nodes'
         cure = 'use ELEMENTS='//as_text(ceiling(1.2_wp*size_of_mesh()*sqrt(worst%error/little)))
         if (body%is_frame) cure = 'use DIVISIONS='//as_text(ceiling(1.2_wp*size_of_mesh()*sqrt(worst%error/little)))
      end select
      text = text//'; '//cure//newline

   contains

      !> Elements of the beam, or of the member that has most.
      pure integer function size_of_mesh() result(elements)
         elements = body%beam%elements
         if (body%is_frame) elements = maxval(body%mesh%first(2:) - body%mesh%first(:size(body%mesh%first) - 1))
      end function size_of_mesh

   end function warning

end module limber_monitor_mode_checks
