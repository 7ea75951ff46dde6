!> Coordinates of joints that their kinds leave free, and those that never change: what couplers, drivers, laws and channels may
!> ask for. Floor: model. Source: doc/theory, part 3.
module limber_model_joint_coordinates
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_expression, only: slot_type
   use limber_deck_origin, only: origin_type
   use limber_model_load_parts, only: new_part
   use limber_model_model, only: model_type, joint_type, quantity_type, load_part_type, place_at_point, place_on_line, &
      & place_rolling, along_angle, along_slide, coordinate_joint_angle, coordinate_displacement
   use limber_model_quantities, only: quantity_joint_angle, quantity_joint_spin, quantity_displacement, quantity_sliding_speed, &
      & quantity_force_x, quantity_force_y, quantity_moment
   implicit none
   private
   public :: check_coordinate, check_joint_quantity, warn_of_kept, free_motion

contains

   !> Whether a joint keeps a coordinate as it is. One that a switch opens does not.
   !>
   !> | kind                            | displacement | joint_angle | moment |
   !> |---------------------------------|--------------|-------------|--------|
   !> | REVOLUTE                        | kept         | free        | 0      |
   !> | WELD                            | kept         | kept        |        |
   !> | TRANSLATIONAL                   | free         | kept        |        |
   !> | POINT ON LINE, POINT ON CURVE   | free         | free        | 0      |
   !> | SLIDING, ROD                    | free         | free        | 0      |
   !> | GEAR, BELT, RACK                | free         | free        |        |
   pure logical function keeps(joint, coordinate)
      type(joint_type), intent(in) :: joint
      !> coordinate_joint_angle or coordinate_displacement
      integer, intent(in) :: coordinate
      keeps = joint%switch == 0
      if (coordinate == coordinate_joint_angle) keeps = keeps .and. joint%keeps_angle
      if (coordinate == coordinate_displacement) keeps = keeps .and. joint%place == place_at_point
   end function keeps

   !> Whether a joint exerts no moment about its first point: the last column of that table.
   pure logical function is_without_moment(joint)
      type(joint_type), intent(in) :: joint
      is_without_moment = .not. (joint%keeps_angle .or. joint%place == place_rolling)
   end function is_without_moment

   !> The scalar along which stops and friction of a joint act.
   pure subroutine free_motion(joint, part, found)
      type(joint_type), intent(in) :: joint
      type(load_part_type), intent(out) :: part
      !> False for joints that have no single one
      logical, intent(out) :: found
      found = .true.
      if (joint%is_hinge()) then
         part = new_part(along_angle, joint%points(1), joint%points(2))
      else if (joint%place == place_on_line) then
         part = new_part(along_slide, joint%points(1), joint%points(2))
         part%angle = joint%angle
      else
         found = .false.
      end if
   end subroutine free_motion

   !> Coordinate of a joint that a quantity asks for, or its rate; 0 for other quantities.
   pure integer function coordinate_of(kind) result(coordinate)
      !> Index of the quantity
      integer, intent(in) :: kind
      select case (kind)
      case (quantity_joint_angle, quantity_joint_spin); coordinate = coordinate_joint_angle
      case (quantity_displacement, quantity_sliding_speed); coordinate = coordinate_displacement
      case default; coordinate = 0
      end select
   end function coordinate_of

   !> Reports a coordinate that its joint keeps as it is: of a coupler or driver.
   subroutine check_coordinate(joint, coordinate, origin, diagnostics)
      type(joint_type), intent(in) :: joint
      integer, intent(in) :: coordinate
      type(origin_type), intent(in) :: origin
      type(diagnostics_type), intent(inout) :: diagnostics
      if (keeps(joint, coordinate)) call diagnostics%add(origin, kept(joint, coordinate), free_instead(joint))
   end subroutine check_coordinate

   !> Reports the same in a law.
   subroutine check_joint_quantity(model, quantity, origin, diagnostics)
      type(model_type), intent(in) :: model
      type(quantity_type), intent(in) :: quantity
      type(origin_type), intent(in) :: origin
      type(diagnostics_type), intent(inout) :: diagnostics
      if (coordinate_of(quantity%kind) > 0) call check_coordinate(model%joints(quantity%of), coordinate_of(quantity%kind), &
         & origin, diagnostics)
   end subroutine check_joint_quantity

   !> What is said of such a coordinate.
   pure function kept(joint, coordinate) result(text)
      type(joint_type), intent(in) :: joint
      integer, intent(in) :: coordinate
      character(:), allocatable :: text
      text = trim(merge('joint_angle ', 'displacement', coordinate == coordinate_joint_angle))//" of joint '"//joint%name// &
         & "' never changes: TYPE="//joint%symbol//' keeps it'
   end function kept

   !> The coordinate that such a joint leaves free.
   pure function free_instead(joint) result(text)
      type(joint_type), intent(in) :: joint
      character(:), allocatable :: text
      if (joint%is_weld()) then
         text = 'it leaves no motion free: name another joint'
      else
         text = 'its free coordinate is '//trim(merge('joint_angle ', 'displacement', joint%is_hinge()))
      end if
   end function free_instead

   !> Warns of a channel of a coordinate that its joint keeps, or of a force that there cannot be. A kept angle may be asked for: it
   !> is not always zero.
   subroutine warn_of_kept(model, quantity, slot, diagnostics)
      type(model_type), intent(in) :: model
      type(quantity_type), intent(in) :: quantity
      type(slot_type), intent(in) :: slot
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: coordinate
      if (quantity%of <= 0) return
      coordinate = coordinate_of(quantity%kind)
      if (quantity%of_load) then
         call warn_of_bushing()
      else if (coordinate > 0) then
         associate (joint => model%joints(quantity%of))
            if (keeps(joint, coordinate) .and. quantity%kind /= quantity_joint_angle) &
               & call diagnostics%warn(slot%origin, kept(joint, coordinate), free_instead(joint))
         end associate
      else if (quantity%kind == quantity_moment) then
         associate (joint => model%joints(quantity%of))
            if (joint%is_coupler()) return
            if (is_without_moment(joint)) call diagnostics%warn(slot%origin, 'moment('//slot%argument// &
               & ') is 0 whatever happens: TYPE='//joint%symbol//' leaves the first section free to turn', &
               & 'leave it out; a driver has torque(driver)')
         end associate
      end if

   contains

      !> Of a bushing without stiffness and damping there.
      subroutine warn_of_bushing()
         if (all(quantity%kind /= [quantity_force_x, quantity_force_y, quantity_moment])) return
         associate (resists => model%loads(quantity%of)%resists)
            if (quantity%kind == quantity_moment .and. resists(3)) return
            if (quantity%kind /= quantity_moment .and. any(resists(:2))) return
         end associate
         call diagnostics%warn(slot%origin, trim(slot%name)//'('//slot%argument//') is 0 whatever happens: the bushing has'// &
            & ' no stiffness or damping there', 'leave it out, or add it to *BUSHING')
      end subroutine warn_of_bushing

   end subroutine warn_of_kept

end module limber_model_joint_coordinates
